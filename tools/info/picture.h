// Pictures of 8 bits a channel as PNG.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <vcd/format/error.h>

namespace vcd::tools {

using Colour = std::array<uint8_t, 3>;  // sRGB

struct Picture {
  uint32_t width, height;
  std::vector<Colour> pixels;  // row by row from the top

  Picture(uint32_t w, uint32_t h, Colour ground) : width(w), height(h), pixels(size_t{w} * h, ground) {}

  // Parts outside the picture are left out.
  void fill(int64_t x, int64_t y, int64_t w, int64_t h, Colour colour);
  void paste(const Picture& other, uint32_t x, uint32_t y);
  // One line, its top left corner at x, y; a capital is 14 pixels high. Bytes that are not printable ASCII become "?".
  void write(uint32_t x, uint32_t y, const std::string& text, Colour colour);
};

// The bytes of a PNG file. Error (runtime): it cannot be encoded.
Result<std::string> png_of(const Picture& picture);

}  // namespace vcd::tools
