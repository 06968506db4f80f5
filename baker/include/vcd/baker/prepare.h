// Triangles → the canonical mesh that is baked, hashed and bound to the sidecar.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <vcd/baker/mesh.h>
#include <vcd/format/error.h>

namespace vcd::baker {

// One object, welded and cleaned. Equal geometry gives equal bytes here, whatever file, order or naming it came in, and
// so the same sidecar tree; source_triangles alone tells the order.
struct PreparedMesh {
  std::string name;
  uint32_t source_index = 0;
  std::vector<Position> positions;         // unique, sorted by x, y, z; no -0; every one is used
  std::vector<TriangleIndices> triangles;  // corners ascending, whatever the winding was; sorted
  std::array<float, 3> box_min{};          // padded: spec/vcd-format.md, "Box"
  std::array<float, 3> box_max{};
  std::array<uint8_t, 16> geometry_hash{};  // spec/vcd-format.md, "Geometry hash"
  std::array<double, 3> shift{};            // of the source, likewise
  LeftOut left_out = {};                    // of the source
  std::vector<uint32_t> source_triangles;   // the triangle that each one of the source became; kNone: dropped
  uint64_t duplicate_triangles = 0;         // dropped: same three corners as another one
  uint64_t zero_area_triangles = 0;         // dropped: equal or collinear corners
};

// Positions must be finite and indices in range, as ingest() promises.
// Errors: usage if they are not; invalid_file if every triangle has zero area, unsupported if the box is too large or
// small for 32-bit floats. Takes the source apart to save memory. Safe from any thread.
Result<PreparedMesh> prepare(SourceMesh&& source);

// The positions in grid units, where the padded box is [0, 256]^3: the frame in which cells are classified.
std::vector<Position> positions_in_grid(const PreparedMesh& mesh);

}  // namespace vcd::baker
