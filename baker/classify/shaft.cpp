#include "shaft.h"

#include <algorithm>
#include <cmath>

#include <vcd/format/line_cell.h>

namespace vcd::baker {
namespace {

Square square(uint32_t face, uint32_t first, uint32_t second, double width) {
  const FaceAxes axes = face_axes(face);
  Square s;
  s.min[axes.normal] = s.max[axes.normal] = face % 2 ? double{kGrid} : 0.0;
  s.min[axes.first] = first * width;
  s.max[axes.first] = (first + 1) * width;
  s.min[axes.second] = second * width;
  s.max[axes.second] = (second + 1) * width;
  return s;
}

}  // namespace

std::array<Square, 2> squares(const Cell& cell) {
  const double width = double{kGrid} / (1u << cell.level);
  return {square(kFacePair[cell.pair].low, cell.s, cell.t, width),
          square(kFacePair[cell.pair].high, cell.u, cell.v, width)};
}

Shaft make_shaft(const Cell& cell) {
  constexpr double kGrowth = double{kGuardBand} + kProofSlack;
  auto [a, b] = squares(cell);
  for (Square* s : {&a, &b})
    for (int i = 0; i < 3; ++i) s->min[i] -= kGrowth, s->max[i] += kGrowth;

  Shaft shaft{};
  for (float& offset : shaft.offset) offset = 1.0f;
  // Leaving a plane out makes the shaft larger, which is safe; twelve hold all that cells of this space have.
  const auto add = [&](int i, double ni, int j, double nj, double offset) {
    if (shaft.planes == kShaftPlanes) return;
    shaft.normal[i][shaft.planes] = static_cast<float>(ni);
    shaft.normal[j][shaft.planes] = static_cast<float>(nj);
    shaft.offset[shaft.planes++] = static_cast<float>(offset);
  };
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    for (int signs = 0; signs < 4; ++signs) {
      // The corner of each rectangle that lies farthest in this quadrant, and the line through both.
      const double si = signs & 1 ? 1 : -1, sj = signs & 2 ? 1 : -1;
      const double ai = si > 0 ? a.max[i] : a.min[i], aj = sj > 0 ? a.max[j] : a.min[j];
      const double di = (si > 0 ? b.max[i] : b.min[i]) - ai, dj = (sj > 0 ? b.max[j] : b.min[j]) - aj;
      if (di * si * dj * sj >= 0) continue;  // not an edge of the hull, or one along an axis
      const double length = std::abs(di) + std::abs(dj);
      const double ni = si * std::abs(dj) / length, nj = sj * std::abs(di) / length;
      add(i, ni, j, nj, ni * ai + nj * aj);
    }
  }
  for (int i = 0; i < 3; ++i) {
    const double low = std::min(a.min[i], b.min[i]), high = std::max(a.max[i], b.max[i]);
    if (low > 0) add(i, -1, (i + 1) % 3, 0, -low);  // the mesh lies inside the grid anyway
    if (high < kGrid) add(i, 1, (i + 1) % 3, 0, high);
  }
  return shaft;
}

}  // namespace vcd::baker
