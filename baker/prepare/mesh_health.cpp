#include <vcd/baker/mesh_health.h>

#include "disjoint_sets.h"
#include "topology.h"

namespace vcd::baker {

MeshHealth mesh_health(size_t vertex_count, std::span<const TriangleIndices> triangles) {
  MeshHealth health;
  const std::vector<EdgeSide> sides = edge_sides(triangles);
  DisjointSets pieces(triangles.size()), rims(vertex_count);
  std::vector<bool> on_rim(vertex_count);
  health.components = triangles.size();
  for_each_edge(sides, [&](std::span<const EdgeSide> edge) {
    const auto [low, high, slot] = edge[0];
    for (const EdgeSide& side : edge.subspan(1)) health.components -= pieces.join(slot / 3, side.slot / 3);
    if (edge.size() > 2) health.nonmanifold_edges.push_back({low, high});
    if (edge.size() > 1) return;
    health.boundary_edges.push_back({low, high});
    // Their vertices, less one for each edge that joins two.
    for (const uint32_t vertex : {low, high}) health.boundary_loops += !on_rim[vertex], on_rim[vertex] = true;
    health.boundary_loops -= rims.join(low, high);
  });

  const std::vector<uint32_t> fans = corner_fans(triangles, sides);
  std::vector<uint8_t> fans_at(vertex_count);  // 0, 1, more
  for (uint32_t corner = 0; corner < fans.size(); ++corner) {
    uint8_t& count = fans_at[triangles[corner / 3][corner % 3]];
    if (fans[corner] == corner && count < 2) ++count;
  }
  for (uint32_t vertex = 0; vertex < vertex_count; ++vertex)
    if (fans_at[vertex] > 1) health.nonmanifold_vertices.push_back(vertex);
  return health;
}

}  // namespace vcd::baker
