// From the world to an instance's grid and on to its object's frame.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <vcd/format/line_cell.h>
#include <vcd/format/segment.h>

namespace vcd {

// An instance's transform from the world to its object's grid: grid = Σ column[a] · (world − centre)[a] + offset, in
// the first three of four.
struct alignas(16) ToGrid {
  float centre[4];     // the fourth is 0
  float column[3][4];  // the fourth is the sum of the others' absolute values: rounding grows with it
  float offset[4];     // the fourth is 0
};

// What stands for a transform that has no inverse in floats: every line in it is doubtful, for its numbers are NaN.
inline constexpr ToGrid kNoInverse = [] {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  ToGrid grid{};
  for (int a = 0; a < 3; ++a) {
    grid.offset[a] = kNan;
    for (float& x : grid.column[a]) x = kNan;
  }
  return grid;
}();
inline bool has_inverse(const ToGrid& grid) { return !std::isnan(grid.offset[0]); }

// A segment of the world in an instance's grid.
struct PlacedSegment {
  Segment in_grid;
  float fixed, moving;  // what rounding grows with: fixed + |t| · moving, but for the origin's norm in the grid
};
inline PlacedSegment placed(const ToGrid& grid, const Segment& world) {
  const auto& c = grid.column;
  float o[3];
  for (int a = 0; a < 3; ++a) o[a] = world.origin[a] - grid.centre[a];
  const float* d = world.direction;
  PlacedSegment in{{{}, world.t_min, {}, world.t_max},
                   (c[0][3] * std::abs(o[0]) + c[1][3] * std::abs(o[1])) + c[2][3] * std::abs(o[2]),
                   (c[0][3] * std::abs(d[0]) + c[1][3] * std::abs(d[1])) + c[2][3] * std::abs(d[2])};
  for (int i = 0; i < 3; ++i) {
    in.in_grid.origin[i] = (c[0][i] * o[0] + c[1][i] * o[1]) + (c[2][i] * o[2] + grid.offset[i]);
    in.in_grid.direction[i] = (c[0][i] * d[0] + c[1][i] * d[1]) + c[2][i] * d[2];
  }
  return in;
}

// From an object's grid to its frame: grid · unit + min.
struct alignas(16) ToFrame {
  float unit[4], min[4];  // the fourth is 0
};
inline Segment in_frame(const ToFrame& frame, Segment grid) {
  for (int a = 0; a < 3; ++a) {
    grid.origin[a] = grid.origin[a] * frame.unit[a] + frame.min[a];
    grid.direction[a] *= frame.unit[a];
  }
  return grid;
}

// The same in doubles, where nothing overflows or underflows on the way. Nothing if floats cannot hold the result.
inline std::optional<Segment> far_in_frame(const ToGrid& grid, const ToFrame& frame, const Segment& world) {
  Segment segment{{}, world.t_min, {}, world.t_max};
  float longest = 0;
  bool finite = true;
  for (int i = 0; i < 3; ++i) {
    double o = grid.offset[i], d = 0;
    for (int a = 0; a < 3; ++a) {
      o += double{grid.column[a][i]} * (double{world.origin[a]} - double{grid.centre[a]});
      d += double{grid.column[a][i]} * double{world.direction[a]};
    }
    segment.origin[i] = static_cast<float>(o * double{frame.unit[i]} + double{frame.min[i]});
    segment.direction[i] = static_cast<float>(d * double{frame.unit[i]});
    finite &= std::isfinite(segment.origin[i]) && std::isfinite(segment.direction[i]);
    longest = std::max(longest, std::abs(segment.direction[i]));
  }
  return finite && longest >= 0x1p-100f ? std::optional(segment) : std::nullopt;
}

// Beyond this reach a transform's rounding could leave the guard band: unclassified. See spec/proofs.md, "Scenes".
inline constexpr float kFarthestReach = 0x1p16f;

inline constexpr GridFrame kGridItself = {{0, 0, 0, 0}, {1, 1, 1, 0}};

}  // namespace vcd
