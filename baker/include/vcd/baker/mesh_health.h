// What of a mesh is no closed surface.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <vcd/baker/mesh.h>

namespace vcd::baker {

struct MeshHealth {
  using Edge = std::array<uint32_t, 2>;  // vertices, the lower first

  uint64_t components = 0;                     // pieces whose triangles hang together by edges
  uint64_t boundary_loops = 0;                 // pieces that the boundary edges form: holes and rims
  std::vector<Edge> boundary_edges;            // of one triangle
  std::vector<Edge> nonmanifold_edges;         // of three triangles or more
  std::vector<uint32_t> nonmanifold_vertices;  // where triangles meet that no edges there join: hourglasses

  bool closed() const { return boundary_edges.empty(); }
  bool is_manifold() const { return nonmanifold_edges.empty() && nonmanifold_vertices.empty(); }
};

// Of a mesh whose equal positions are one, as in a PreparedMesh, and whose triangles have three different corners. The
// lists are sorted; winding does not matter. vertex_count: indices are below it. Safe from any thread.
MeshHealth mesh_health(size_t vertex_count, std::span<const TriangleIndices> triangles);

}  // namespace vcd::baker
