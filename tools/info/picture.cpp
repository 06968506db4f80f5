#include "picture.h"

#include <algorithm>
#include <cstring>

#include <png.h>
#include <stb_easy_font.h>

namespace vcd::tools {

void Picture::fill(int64_t x, int64_t y, int64_t w, int64_t h, Colour colour) {
  const int64_t right = std::min<int64_t>(x + w, width), bottom = std::min<int64_t>(y + h, height);
  x = std::max<int64_t>(x, 0);
  for (int64_t row = std::max<int64_t>(y, 0); row < bottom; ++row)
    if (x < right) std::fill_n(pixels.begin() + row * width + x, right - x, colour);
}

void Picture::paste(const Picture& other, uint32_t x, uint32_t y) {
  for (uint32_t row = 0; row < other.height; ++row)
    for (uint32_t column = 0; column < other.width; ++column)
      if (x + column < width && y + row < height)
        pixels[size_t{y + row} * width + x + column] = other.pixels[size_t{row} * other.width + column];
}

void Picture::write(uint32_t x, uint32_t y, const std::string& text, Colour colour) {
  constexpr float kScale = 2;  // the font's own pixels are too small to read
  struct Corner {
    float x, y, z;
    uint8_t colour[4];
  };
  std::string ascii;
  for (const char c : text) ascii += c >= 32 && c < 127 ? c : '?';
  std::vector<Corner> corners(80 * (ascii.size() + 1));
  const int quads = stb_easy_font_print(0, 0, ascii.data(), nullptr, corners.data(),
                                        static_cast<int>(corners.size() * sizeof(Corner)));
  for (int q = 0; q < quads; ++q) {
    const Corner& from = corners[static_cast<size_t>(q) * 4];
    const Corner& to = corners[static_cast<size_t>(q) * 4 + 2];
    const auto scaled = [](float length) { return static_cast<int64_t>(length * kScale); };
    fill(x + scaled(from.x), y + scaled(from.y), scaled(to.x - from.x), scaled(to.y - from.y), colour);
  }
}

Result<std::string> png_of(const Picture& picture) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = picture.width, png.height = picture.height, png.format = PNG_FORMAT_RGB;
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(png), '\0');
  png_alloc_size_t size = bytes.size();
  if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, picture.pixels.data(), 0, nullptr))
    return Error{ErrorCode::runtime, std::string("a picture cannot be encoded: ") + png.message};
  bytes.resize(size);
  return bytes;
}

}  // namespace vcd::tools
