#include "views.h"

#include <cmath>
#include <cstdio>
#include <numbers>

#include "common/describe.h"
#include "info/cell_of_line.h"

namespace vcd::tools {
namespace {

constexpr int kViews[8][2] = {{0, 0}, {45, 0}, {90, 0}, {135, 0}, {30, 30}, {30, 60}, {30, -40}, {200, 25}};
constexpr const char* kClassNames[kClasses] = {"clear", "blocked, proven", "unclassified", "blocked, by statistics"};

using Vector = std::array<double, 3>;

View view_of(const ObjectContents& object, int azimuth, int elevation, uint32_t pixels) {
  const auto& [low, high] = std::pair(object.record->box_min, object.record->box_max);
  const double a = azimuth * std::numbers::pi / 180, e = elevation * std::numbers::pi / 180;
  const Vector towards = {std::cos(e) * std::sin(a), std::sin(e), std::cos(e) * std::cos(a)};
  const Vector right = {std::cos(a), 0, -std::sin(a)};
  const Vector up = {towards[1] * right[2] - towards[2] * right[1], towards[2] * right[0] - towards[0] * right[2],
                     towards[0] * right[1] - towards[1] * right[0]};
  const double radius = std::hypot(double{high[0]} - low[0], double{high[1]} - low[1], double{high[2]} - low[2]) / 2;
  View view{azimuth, elevation, {}, Picture(pixels, pixels, kClassColours[0])};
  for (uint32_t row = 0; row < pixels; ++row)
    for (uint32_t column = 0; column < pixels; ++column) {
      const double x = radius * ((column + 0.5) / pixels * 2 - 1), y = radius * (1 - (row + 0.5) / pixels * 2);
      Vector point;
      for (size_t k = 0; k < 3; ++k) point[k] = (double{low[k]} + high[k]) / 2 + x * right[k] + y * up[k];
      const auto found = cell_of_line(object, point, towards);
      const auto kind = static_cast<size_t>(found ? found->cell : CellClass::clear);
      view.picture.pixels[size_t{row} * pixels + column] = kClassColours[kind];
      view.shares[kind] += 1 / static_cast<double>(size_t{pixels} * pixels);
    }
  return view;
}

constexpr uint32_t kPixels = 384, kGap = 16, kLine = 24;
constexpr uint32_t kTile = kPixels + kGap, kCaption = 3 * kLine;
constexpr uint32_t kTitle = 3 * kLine, kRow = kPixels + kCaption + kGap, kBlock = 2 * kRow + 2 * kLine;
constexpr Colour kGround = {255, 255, 255}, kInk = {30, 33, 38}, kDim = {95, 102, 112};

void write_legend(Picture& picture, uint32_t y) {
  uint32_t x = kGap;
  for (const uint32_t kind : {0, 1, 3, 2}) {
    picture.fill(x, y, kLine, 14, kDim);
    picture.fill(x + 1, y + 1, kLine - 2, 12, kClassColours[kind]);
    picture.write(x + kLine + 8, y, kClassNames[kind], kInk);
    x += kTile;
  }
}

void draw_view(Picture& picture, const View& view, uint32_t x, uint32_t y) {
  picture.paste(view.picture, x, y);
  char lines[3][80];
  std::snprintf(lines[0], sizeof lines[0], "azimuth %d, elevation %d", view.azimuth, view.elevation);
  std::snprintf(lines[1], sizeof lines[1], "clear %.0f %%, unclassified %.0f %%", 100 * view.shares[0],
                100 * view.shares[2]);
  std::snprintf(lines[2], sizeof lines[2], "proven %.0f %%, by statistics %.0f %%", 100 * view.shares[1],
                100 * view.shares[3]);
  for (uint32_t i = 0; i < 3; ++i) picture.write(x, y + kPixels + 8 + i * 22, lines[i], i == 0 ? kInk : kDim);
}

}  // namespace

std::vector<View> views_of(const ObjectContents& object, uint32_t pixels) {
  std::vector<View> views;
  for (const auto& [azimuth, elevation] : kViews) views.push_back(view_of(object, azimuth, elevation, pixels));
  return views;
}

Result<std::string> classes_as_png(const SidecarContents& sidecar, const std::string& name) try {
  const size_t count = sidecar.objects.size();
  if (count == 0) return Error{ErrorCode::usage, name + ": has no objects to draw"};
  if (count > kMostPictured)
    return Error{ErrorCode::usage, name + ": a picture holds " + std::to_string(kMostPictured) +
                                       " objects, and the file has " + std::to_string(count)};
  Picture picture(4 * kTile + kGap, kTitle + static_cast<uint32_t>(count) * kBlock + kGap, kGround);
  picture.write(kGap, kGap, name + ": what look-ups say of lines, from eight directions", kInk);
  write_legend(picture, kGap + kLine);
  for (uint32_t i = 0; i < count; ++i) {
    const ObjectContents& object = sidecar.objects[i];
    const uint32_t top = kTitle + i * kBlock;
    picture.write(kGap, top + 8, "object " + std::to_string(object.record->source_index) + " " + printable(object.name),
                  kInk);
    const std::vector<View> views = views_of(object, kPixels);
    for (uint32_t v = 0; v < views.size(); ++v)
      draw_view(picture, views[v], kGap + v % 4 * kTile, top + 2 * kLine + v / 4 * kRow);
  }
  return png_of(picture);
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, name + ": out of memory"};
}

}  // namespace vcd::tools
