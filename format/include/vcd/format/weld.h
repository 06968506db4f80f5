// Bit-exact welding and cleaning, which the geometry hash is of: spec/vcd-format.md, "Geometry hash". A weld by
// tolerance would close real gaps and so forge promises.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace vcd {

using Position = std::array<float, 3>;            // x, y, z in the object's own frame and unit
using TriangleIndices = std::array<uint32_t, 3>;  // into the positions of the same mesh, counter-clockwise or not

struct WeldedMesh {
  std::vector<Position> positions;         // unique, sorted by x, y, z; no -0; every one is used
  std::vector<TriangleIndices> triangles;  // corners ascending, whatever the winding was; sorted; none without an area
  std::vector<uint32_t> source_triangles;  // the triangle that each one of the source became; kNone: dropped
  uint64_t duplicate_triangles = 0;        // dropped: same three corners as another one
  uint64_t zero_area_triangles = 0;        // dropped: equal or collinear corners
};

// Whether all positions are finite, all indices in range, and both fewer than 2^32.
bool is_sound(std::span<const Position> positions, std::span<const TriangleIndices> triangles);

// Takes the mesh, which must be sound, apart to save memory. Throws nothing but std::bad_alloc.
WeldedMesh weld(std::vector<Position>&& positions, std::vector<TriangleIndices>&& triangles);

// True if the three points lie on one line in exact arithmetic.
bool has_zero_area(const Position& a, const Position& b, const Position& c);

}  // namespace vcd
