#include "image.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <png.h>

#include <vcd/writer/atomic_file.h>

namespace vcd::render {
namespace {

uint8_t srgb_byte(float linear) {
  const float x = std::clamp(linear, 0.0f, 1.0f);
  const float encoded = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
  return static_cast<uint8_t>(encoded * 255 + 0.5f);
}

std::optional<Error> write_whole(const std::filesystem::path& path, Bytes bytes) {
  AtomicFile file(path);
  file.append(bytes);
  const auto written = file.commit();
  return written ? std::nullopt : std::optional(written.error());
}

// OpenEXR writes into memory, so that the file appears whole or not at all.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream() : Imf::OStream("memory") {}
  void write(const char* from, int count) override {
    const size_t end = at_ + static_cast<size_t>(count);
    if (bytes.size() < end) bytes.resize(end);
    std::memcpy(bytes.data() + at_, from, static_cast<size_t>(count));
    at_ = end;
  }
  uint64_t tellp() override { return at_; }
  void seekp(uint64_t position) override { at_ = position; }

  std::vector<std::byte> bytes;

 private:
  size_t at_ = 0;
};

float luminance(Vec3 c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

}  // namespace

std::optional<Error> write_png(const std::filesystem::path& path, const Image& image) {
  std::vector<uint8_t> rgb;
  rgb.reserve(3 * image.pixels.size());
  for (const Vec3& p : image.pixels)
    for (float channel : {p.x, p.y, p.z}) rgb.push_back(srgb_byte(channel));
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = image.width, png.height = image.height, png.format = PNG_FORMAT_RGB;
  std::vector<std::byte> bytes(PNG_IMAGE_PNG_SIZE_MAX(png));
  png_alloc_size_t size = bytes.size();
  if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, rgb.data(), 0, nullptr))
    return Error{ErrorCode::runtime, path.string() + ": cannot be encoded: " + png.message};
  return write_whole(path, Bytes(bytes).first(size));
}

std::optional<Error> write_exr(const std::filesystem::path& path, const Image& image) try {
  Imf::Header header(static_cast<int>(image.width), static_cast<int>(image.height));
  Imf::FrameBuffer frame;
  char* const base = const_cast<char*>(reinterpret_cast<const char*>(image.pixels.data()));
  const char* const names[3] = {"R", "G", "B"};
  for (size_t c = 0; c < 3; ++c) {
    header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
    frame.insert(names[c], Imf::Slice(Imf::FLOAT, base + c * sizeof(float), sizeof(Vec3), sizeof(Vec3) * image.width));
  }
  MemoryStream stream;
  {
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(frame);
    file.writePixels(static_cast<int>(image.height));
  }
  return write_whole(path, stream.bytes);
} catch (const std::exception& e) {
  return Error{ErrorCode::runtime, path.string() + ": cannot be encoded: " + e.what()};
}

Image tone_mapped(const Image& image, float exposure, float white) {
  Image mapped = image;
  for (Vec3& p : mapped.pixels) {
    p = p * exposure;
    const float l = luminance(p);
    p = p * ((1 + l / (white * white)) / (1 + l));
  }
  return mapped;
}

Difference compare(const Image& a, const Image& b) {
  Difference difference;
  double squares = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    const Vec3 d = a.pixels[i] - b.pixels[i];
    double largest = 0;
    for (float channel : {d.x, d.y, d.z}) {
      squares += static_cast<double>(channel) * channel;
      largest = std::max(largest, static_cast<double>(std::abs(channel)));
    }
    difference.maximum = std::max(difference.maximum, largest);
    difference.pixels += largest > 0;
  }
  difference.rmse = std::sqrt(squares / static_cast<double>(3 * std::max<size_t>(a.pixels.size(), 1)));
  return difference;
}

Image amplified_difference(const Image& a, const Image& b, float factor) {
  Image out(a.width, a.height);
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    const Vec3 d = a.pixels[i] - b.pixels[i];
    out.pixels[i] = Vec3{std::abs(d.x), std::abs(d.y), std::abs(d.z)} * factor;
  }
  return out;
}

}  // namespace vcd::render
