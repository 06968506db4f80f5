#include "box.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <vcd/format/line_cell.h>

namespace vcd::baker {
namespace {

constexpr double kPadding = 0x1p-10;      // of the extent, on each side: twice what the format demands
constexpr double kLeastMargin = 0x1p-11;  // of the final extent: spec/vcd-format.md, "Box"
constexpr double kThinnest = 1e-3;        // of the diagonal

// The nearest float not above (towards -infinity) or not below (towards +infinity) x.
float round_towards(double x, float direction) {
  const float nearest = static_cast<float>(x);
  const bool inside = direction < 0 ? nearest > x : nearest < x;
  return inside ? std::nextafter(nearest, direction) : nearest;
}

}  // namespace

bool pad_box(PreparedMesh& mesh) {
  constexpr float kUp = std::numeric_limits<float>::infinity();
  Position low = mesh.positions.front(), high = low;
  for (const Position& p : mesh.positions)
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], p[a]);
      high[a] = std::max(high[a], p[a]);
    }
  double diagonal = 0;
  for (int a = 0; a < 3; ++a) diagonal = std::hypot(diagonal, static_cast<double>(high[a]) - low[a]);

  for (int a = 0; a < 3; ++a) {
    const double extent = std::max(static_cast<double>(high[a]) - low[a], diagonal * kThinnest);
    const double center = (static_cast<double>(low[a]) + high[a]) / 2;
    const double half = extent * (0.5 + kPadding);
    float& box_low = mesh.box_min[a];
    float& box_high = mesh.box_max[a];
    box_low = round_towards(center - half, -kUp);
    box_high = round_towards(center + half, kUp);
    // Far from the origin a float's step can exceed the padding; then one more step is more than enough.
    const auto margin = [&] { return kLeastMargin * (static_cast<double>(box_high) - box_low); };
    while (std::isfinite(box_low) && std::isfinite(box_high) &&
           (low[a] - static_cast<double>(box_low) < margin() || static_cast<double>(box_high) - high[a] < margin())) {
      box_low = std::nextafter(box_low, -kUp);
      box_high = std::nextafter(box_high, kUp);
    }
    if (!usable_extent(box_high - box_low)) return false;
  }
  return true;
}

}  // namespace vcd::baker
