// Where a surface goes on across the edges of its triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <vcd/baker/mesh.h>

namespace vcd::baker {

inline constexpr uint32_t kBoundary = 0xFFFFFFFF;

// neighbour[3 t + i] is the triangle that continues triangle t across its edge from corner i to corner (i + 1) % 3, or
// kBoundary. The relation is symmetric, and pairs the triangles of an edge: the proofs count crossings modulo 2, and an
// edge whose triangles come in pairs cannot change that number. Winding does not matter.
//
// Where more than two triangles share an edge, those two that continue each other straightest are paired first; a
// triangle without a partner has a boundary there, which is always safe.
std::vector<uint32_t> pair_edges(std::span<const Position> positions, std::span<const TriangleIndices> triangles);

}  // namespace vcd::baker
