// Where a surface goes on across the edges of its triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <vcd/baker/mesh.h>

namespace vcd::baker {

inline constexpr uint32_t kBoundary = 0xFFFFFFFF;

// One triangle at an edge.
struct EdgeSide {
  uint32_t low, high;  // the edge's vertices
  uint32_t slot;       // 3 · triangle + edge; edge i runs from corner i to corner (i + 1) % 3
};

// All of them, those of one edge together, edges by their vertices and sides by their slots.
std::vector<EdgeSide> edge_sides(std::span<const TriangleIndices> triangles);

// Calls visit(std::span<const EdgeSide>) for each edge.
template <class Visit>
void for_each_edge(std::span<const EdgeSide> sides, Visit visit) {
  for (size_t first = 0, end; first < sides.size(); first = end) {
    end = first + 1;
    while (end < sides.size() && sides[end].low == sides[first].low && sides[end].high == sides[first].high) ++end;
    visit(sides.subspan(first, end - first));
  }
}

// fan[3 t + i] is the first corner of the fan of corner i of triangle t: of the corners at its vertex whose triangles
// hang together by edges there. On a surface each vertex has one fan. sides: edge_sides() of the triangles.
std::vector<uint32_t> corner_fans(std::span<const TriangleIndices> triangles, std::span<const EdgeSide> sides);

// neighbour[3 t + i] is the triangle that continues triangle t across its edge from corner i to corner (i + 1) % 3, or
// kBoundary. The relation is symmetric, and pairs the triangles of an edge: the proofs count crossings modulo 2, and an
// edge whose triangles come in pairs cannot change that number. Winding does not matter.
//
// Where more than two triangles share an edge, those two that continue each other straightest are paired first; a
// triangle without a partner has a boundary there, which is always safe.
std::vector<uint32_t> pair_edges(std::span<const Position> positions, std::span<const TriangleIndices> triangles);

}  // namespace vcd::baker
