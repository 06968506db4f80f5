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

struct PlacedGrid {
  const ToGrid& grid;

  [[gnu::always_inline]] LineCell locate(const Segment& world) const { return locate_with_length(world).line; }

  // The line is valid only where the guard band covers what the transform's rounding does.
  [[gnu::always_inline]] Located locate_with_length(const Segment& world) const {
    const Segment in = in_grid(grid, world);
    const float *d = world.direction, o[3] = {world.origin[0] - grid.centre[0], world.origin[1] - grid.centre[1],
                                              world.origin[2] - grid.centre[2]};
    LineCell line = vcd::locate(kGridItself, in);
    const float reach =
        (weighted(o) + norm(in.origin)) + std::max(std::abs(line.t_entry), std::abs(line.t_exit)) * weighted(d);
    line.valid &= reach <= kFarthestReach;
    return {line, (line.t_exit - line.t_entry) * norm(in.direction)};
  }

 private:
  float weighted(const float* x) const {
    return (grid.column[0][3] * std::abs(x[0]) + grid.column[1][3] * std::abs(x[1])) +
           grid.column[2][3] * std::abs(x[2]);
  }
  static float norm(const float* x) { return (std::abs(x[0]) + std::abs(x[1])) + std::abs(x[2]); }
};

}  // namespace vcd
