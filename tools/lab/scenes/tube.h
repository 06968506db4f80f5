// Hair, trunks and twigs: a tapering tube about a path.
#pragma once

#include <span>

#include <vcd/scenes/scene.h>

#include "vec.h"

namespace vcd::scenes {

struct PathPoint {
  Double3 at;
  double radius;
};

// Appends a tube with open ends through the points (at least two, no two neighbours equal):
// 2 · sides · (points - 1) triangles, on the grid of on_grid.
void append_tube(Mesh& mesh, std::span<const PathPoint> path, uint32_t sides);

}  // namespace vcd::scenes
