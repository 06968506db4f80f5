// Where segments come from: the object's own frame, or the world by way of an instance's transform. Kernels take one of
// these two as a parameter; <grids-inl.h> has the same two for lanes.
#pragma once

#include <algorithm>
#include <cmath>

#include <vcd/format/line_cell.h>

#include "lookup/to_grid.h"

namespace vcd {

struct Located {
  LineCell line;
  float length;  // of the line's way through the box, in the L1 norm of grid units
};

struct OwnGrid {
  const GridFrame& frame;

  [[gnu::always_inline]] LineCell locate(const Segment& segment) const { return vcd::locate(frame, segment); }
};

// Valid only where the guard band covers what the transform's rounding does.
[[gnu::always_inline]] inline Located located(const PlacedSegment& placed) {
  const Segment& in = placed.in_grid;
  const auto norm = [](const float* x) { return (std::abs(x[0]) + std::abs(x[1])) + std::abs(x[2]); };
  LineCell line = locate(kGridItself, in);
  const float reach =
      (placed.fixed + norm(in.origin)) + std::max(std::abs(line.t_entry), std::abs(line.t_exit)) * placed.moving;
  line.valid &= reach <= kFarthestReach;
  return {line, (line.t_exit - line.t_entry) * norm(in.direction)};
}

struct PlacedGrid {
  const ToGrid& grid;

  [[gnu::always_inline]] LineCell locate(const Segment& world) const { return located(placed(grid, world)).line; }
};

}  // namespace vcd
