// Pictures in memory and on disk.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <vcd/format/error.h>

#include "vec.h"

namespace vcd::render {

struct Image {
  uint32_t width = 0, height = 0;
  std::vector<Vec3> pixels;  // linear RGB, row by row from the top

  Image() = default;
  Image(uint32_t w, uint32_t h) : width(w), height(h), pixels(size_t{w} * h) {}
};

// 8 bits a channel, sRGB, clamped. Errors of both: io, naming the file. Both replace a file whole or not at all.
std::optional<Error> write_png(const std::filesystem::path& path, const Image& image);
// OpenEXR, 32-bit float, linear.
std::optional<Error> write_exr(const std::filesystem::path& path, const Image& image);

// Brightness that a display shows from light of any strength: Reinhard's curve on luminance, with a white point
// (Reinhard et al., Photographic Tone Reproduction for Digital Images, 2002, equation 4).
Image tone_mapped(const Image& image, float exposure = 1, float white = 2);

struct Difference {
  double rmse = 0, maximum = 0;  // over all channels of all pixels
  uint64_t pixels = 0;           // that differ at all
};
Difference compare(const Image& a, const Image& b);  // of the same size
Image amplified_difference(const Image& a, const Image& b, float factor);

}  // namespace vcd::render
