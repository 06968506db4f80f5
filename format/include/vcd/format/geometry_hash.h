// What a mesh is known by: the same for equal geometry, whatever its file, order, winding or duplicates. It finds the
// sidecar of a renderer's own buffers: Sidecar::find(), SidecarStore.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <vcd/format/error.h>
#include <vcd/format/weld.h>

namespace vcd {

using GeometryHash = std::array<uint8_t, 16>;  // ObjectRecord::geometry_hash: XXH3-128, most significant byte first

// Three floats at first, first + stride, …; at any alignment. In the object's frame, as they were when it was baked.
struct PositionBuffer {
  const void* first;
  size_t count;
  size_t stride = 3 * sizeof(float);  // bytes
};

// Three or four indices at first, first + stride, …; at any alignment. A quad {a, b, c, d} is the triangles {a, b, d}
// and {c, d, b}, as Embree cuts it; one with c = d is the triangle {a, b, d}.
struct IndexBuffer {
  const void* first;
  size_t count;             // of triangles or quads
  uint32_t corners = 3;     // or 4
  uint32_t index_size = 4;  // bytes, or 2
  size_t stride = 0;        // bytes; 0: corners * index_size
};

// Copies of what the buffers hold; two triangles of a quad. The indices may be out of range. Both throw std::bad_alloc.
// Errors: usage (corners or index_size is another number).
std::vector<Position> positions_of(const PositionBuffer& positions);
Result<std::vector<TriangleIndices>> triangles_of(const IndexBuffer& faces);

// The hash that the baker would give. Copies and sorts the mesh: once a mesh, not once a frame.
// Errors: usage (corners, index_size, a position that is not finite, or an index out of range); invalid_file (no
// triangle has an area, so that nothing can be baked); runtime (out of memory). Safe from any thread.
Result<GeometryHash> geometry_hash(const PositionBuffer& positions, const IndexBuffer& faces);
Result<GeometryHash> geometry_hash(std::span<const Position> positions, std::span<const TriangleIndices> triangles);

// Of a mesh that is welded already.
GeometryHash geometry_hash(const WeldedMesh& mesh);

}  // namespace vcd
