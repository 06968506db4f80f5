#include "false_colour.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <stb_easy_font.h>

namespace vcd::render {
namespace {

// Samples of Matplotlib's "inferno" (Smith and van der Walt, CC0), sRGB: even steps of lightness, whatever one's eyes.
constexpr uint8_t kColours[][3] = {{0, 0, 4},      {22, 11, 57},   {66, 10, 104},  {106, 23, 110},
                                   {147, 38, 103}, {188, 55, 84},  {221, 81, 58},  {243, 120, 25},
                                   {252, 165, 10}, {246, 215, 70}, {252, 255, 164}};
constexpr size_t kColourCount = std::size(kColours);

float linear(double srgb) {
  return static_cast<float>(srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4));
}

Vec3 colour(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (kColourCount - 1);
  const auto below = std::min(static_cast<size_t>(at), kColourCount - 2);
  const double f = at - static_cast<double>(below);
  const auto channel = [&](int c) { return linear((kColours[below][c] * (1 - f) + kColours[below + 1][c] * f) / 255); };
  return {channel(0), channel(1), channel(2)};
}

void write(Image& image, uint32_t x, uint32_t y, const std::string& text) {
  struct Vertex {
    float x, y, z;
    uint8_t colour[4];
  };
  std::vector<Vertex> vertices(text.size() * 64 + 64);
  std::string copy = text;
  const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, vertices.data(),
                                        static_cast<int>(vertices.size() * sizeof(Vertex)));
  for (int q = 0; q < quads; ++q) {
    const Vertex &low = vertices[4 * static_cast<size_t>(q)], &high = vertices[4 * static_cast<size_t>(q) + 2];
    for (auto row = static_cast<uint32_t>(low.y); row < static_cast<uint32_t>(high.y); ++row)
      for (auto column = static_cast<uint32_t>(low.x); column < static_cast<uint32_t>(high.x); ++column)
        if (x + column < image.width && y + row < image.height)
          image.pixels[size_t{y + row} * image.width + x + column] = {1, 1, 1};
  }
}

uint32_t text_width(const std::string& text) {
  std::string copy = text;
  return static_cast<uint32_t>(stb_easy_font_width(copy.data()));
}

std::string number(double value) {  // "3.75k"
  const char* unit = "";
  for (const char* larger : {"k", "M", "G"})
    if (value >= 1000) value /= 1000, unit = larger;
  char text[32];
  std::snprintf(text, sizeof text, "%.4g%s", value, unit);
  return text;
}

}  // namespace

double scale_for(std::vector<double> counts) {
  if (counts.empty()) return 1;
  const size_t at = std::min(counts.size() - 1, counts.size() * 995 / 1000);
  std::nth_element(counts.begin(), counts.begin() + static_cast<std::ptrdiff_t>(at), counts.end());
  const double wanted = std::max(counts[at], 1.0), power = std::pow(10.0, std::floor(std::log10(wanted)));
  for (double factor : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0})
    if (factor * power >= wanted) return factor * power;
  return 10 * power;
}

Image false_colour(const std::vector<double>& counts, uint32_t width, uint32_t height, double maximum,
                   const std::string& caption) {
  constexpr uint32_t kStrip = 36, kBarTop = 4, kBarHeight = 10, kNumbers = 16, kCaption = 26;
  Image image(width, height + kStrip);
  for (size_t i = 0; i < counts.size(); ++i) image.pixels[i] = colour(counts[i] / maximum);
  const uint32_t margin = std::min(8u, width / 4), bar = width - 2 * margin;
  for (uint32_t x = 0; x < bar; ++x)
    for (uint32_t y = 0; y < kBarHeight; ++y)
      image.pixels[size_t{height + kBarTop + y} * width + margin + x] = colour((x + 0.5) / bar);
  for (int tick = 0; tick <= 4; ++tick) {
    const std::string text = (tick == 4 ? ">" : "") + number(maximum * tick / 4);
    const double center = margin + bar * tick / 4.0 - text_width(text) / 2.0;
    const double last = width > text_width(text) ? width - text_width(text) : 0;
    write(image, static_cast<uint32_t>(std::clamp(center, 0.0, last)), height + kNumbers, text);
  }
  write(image, margin, height + kCaption, caption);
  return image;
}

}  // namespace vcd::render
