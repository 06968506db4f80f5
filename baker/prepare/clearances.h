// How much of the box's outermost part is empty.
#pragma once

#include <cstdint>
#include <vector>

#include <vcd/format/layout.h>

#include "prepare/grid_mesh.h"

namespace vcd::baker {

// kClearanceBytes bytes, as the MARG section has them: for each square of each face the whole number of grid units, at
// most 255, such that every point of the mesh is further than that, and kClearanceSlack more, from every point of the
// square in at least one of the three coordinates.
std::vector<uint8_t> clearances_of(const GridMesh& mesh);

// Covers what line → cell and the comparison of t lose (the guard band's 0.05), and the rounding of vertices to the
// grid.
inline constexpr double kClearanceSlack = 0.125;

}  // namespace vcd::baker
