// One glTF primitive to triangles.
#pragma once

#include <vcd/baker/mesh.h>

#include <cstdint>
#include <map>
#include <vector>

#include "ingest/gltf_buffers.h"

namespace vcd {

enum class GltfMode : uint32_t { points, lines, line_loop, line_strip, triangles, triangle_strip, triangle_fan };

// Throws GltfFailure (invalid_file) for a mode that does not exist.
GltfMode mode_of(const GltfObject& primitive);
bool makes_triangles(GltfMode mode);

// Gathers the primitives of one mesh.
class GltfMeshBuilder {
 public:
  GltfMeshBuilder(const GltfDocument& document, GltfBuffers& buffers) : document_(document), buffers_(buffers) {}

  // Appends a primitive whose mode makes triangles and which has a POSITION. Returns how many of its trailing
  // indices form no triangle (0 to 2); the specification has them ignored.
  // Throws GltfFailure where anything that decides on the triangles is broken: non-finite positions, indices
  // out of range, and whatever accessors, views, buffers and their compression may lack.
  size_t append(const GltfObject& primitive);

  size_t triangle_count() const { return mesh_.triangles.size(); }
  SourceMesh take() { return std::move(mesh_); }

 private:
  size_t append_plain(const GltfObject& primitive, uint32_t position_accessor);
  void append_draco(const GltfObject& primitive, uint32_t position_accessor, const GltfObject& extension);
  uint32_t append_positions(const std::vector<Position>& positions);  // returns the index of the first

  const GltfDocument& document_;
  GltfBuffers& buffers_;
  SourceMesh mesh_;
  // Where the positions of an accessor begin. Primitives often share one; repeating it for each would let a
  // small file grow without bound.
  struct Placed {
    uint32_t first;
    uint32_t count;
  };
  std::map<uint32_t, Placed> placed_;
};

}  // namespace vcd
