// How much of the box's outermost part is empty.
#pragma once

#include <array>
#include <cstdint>

#include <vcd/baker/prepare.h>
#include <vcd/format/layout.h>

namespace vcd {

// For each square of each face, as the MARG section has them: the whole number of grid units, at most 255, such that
// the mesh keeps at least so far, and kMarginSlack more, from every point of the square in one of the three
// coordinates.
std::array<uint8_t, kClearanceBytes> margins_of(const PreparedMesh& mesh);

// Covers what line → cell and the comparison of t lose (the guard band's 0.05), and the rounding of vertices to the
// grid.
inline constexpr double kMarginSlack = 0.125;

}  // namespace vcd
