// What the look-ups of an object say, seen from eight directions: a line a pixel, coloured by the class of its cell.
// python/examples/draw_classes.py draws the same.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <vcd/format/contents.h>
#include <vcd/format/error.h>

#include "info/picture.h"

namespace vcd::tools {

// By the number of CellClass: of light, dark, orange and blue, also on the page.
inline constexpr std::array<Colour, kClasses> kClassColours = {
    {{245, 245, 245}, {40, 44, 52}, {224, 122, 31}, {76, 120, 168}}};

struct View {
  int azimuth, elevation;  // degrees; the eye stands at azimuth 0 in +z, at 90 in +x, at elevation 90 in +y
  std::array<double, kClasses> shares;  // of the pixels
  Picture picture;
};

// Eight square views of so many pixels a side. The whole box is in each. Safe from any thread.
std::vector<View> views_of(const ObjectContents& object, uint32_t pixels);

inline constexpr size_t kMostPictured = 32;

// All objects of a sidecar in one picture, as a PNG file's bytes: eight views each, with a legend.
// name  of the sidecar, for the picture's title
// Errors: usage (no objects, or more than kMostPictured), runtime (out of memory).
Result<std::string> classes_as_png(const SidecarContents& sidecar, const std::string& name);

}  // namespace vcd::tools
