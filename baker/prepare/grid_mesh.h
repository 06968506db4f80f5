// The prepared mesh in grid units, where its padded box is [0, 256]^3.
#pragma once

#include <vector>

#include <vcd/baker/prepare.h>

namespace vcd::baker {

// Made once a bake and read by every pass that looks at triangles, except the audit, which trusts no mapping. Neither
// copied nor moved, since those passes refer to it.
struct GridMesh {
  explicit GridMesh(const PreparedMesh& mesh) : source(mesh), positions(positions_in_grid(mesh)) {}
  explicit GridMesh(PreparedMesh&&) = delete;
  GridMesh(const GridMesh&) = delete;
  GridMesh& operator=(const GridMesh&) = delete;

  const std::vector<TriangleIndices>& triangles() const { return source.triangles; }

  const PreparedMesh& source;       // outlives this
  std::vector<Position> positions;  // one for each of the source's, in the same order
};

}  // namespace vcd::baker
