// Polygons to triangles: the one place that says how.
//
// - A corner that repeats the one before it (the same index) does not count.
// - Fewer than three distinct corners: no triangle.
// - Three: the triangle as it stands.
// - More: the polygon is looked at along the axis nearest to its normal (Newell's). If it is strictly convex
// there,
//   it becomes a fan from its first corner. Else ears are clipped off one by one; where corners are
//   collinear, ears with area go first. A polygon of n corners always gives n - 2 triangles, whose outline is
//   the polygon's.
// - A polygon that crosses itself has no right answer: it is cut as well as can be, and the caller hears of
// it when
//   the ears run out (as they mostly do).
// A non-planar polygon has no single surface either; the same rules choose one.
#pragma once

#include <vcd/baker/mesh.h>

#include <cstdint>
#include <span>
#include <vector>

namespace vcd::baker {

enum class PolygonCut {
  exact,       // the triangles tile the polygon, if it does not cross itself
  degenerate,  // fewer than three distinct corners; nothing was appended
  forced,      // the polygon crosses itself, and so may its triangles
};

// Appends the triangles of one polygon. `corners` are indices into `positions`, all in range (not checked),
// the positions finite. Time: linear in the corners if convex, else mostly quadratic.
PolygonCut append_polygon(std::span<const Position> positions, std::span<const uint32_t> corners,
                          std::vector<TriangleIndices>& triangles);

// Whether the corners, all in range and finite, lie in one plane: to 2^-12 of the polygon's extent, which is more than
// decimal coordinates lose.
bool is_plane(std::span<const Position> positions, std::span<const uint32_t> corners);

}  // namespace vcd::baker
