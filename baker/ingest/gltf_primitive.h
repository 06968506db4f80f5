// One glTF primitive to triangles.
#pragma once

#include <vcd/baker/mesh.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ingest/gltf_buffers.h"

namespace vcd::baker {

enum class GltfMode : uint32_t { points, lines, line_loop, line_strip, triangles, triangle_strip, triangle_fan };

GltfMode mode_of(const tinygltf::Primitive& primitive);
bool makes_triangles(GltfMode mode);

// The positions of accessors, checked to be finite. Accessors that several primitives use are read once and kept until
// the last of them: files in which many small meshes share one would else cost the square of their size.
class GltfPositions {
 public:
  GltfPositions(const GltfDocument& document, GltfBuffers& buffers);

  const std::vector<Position>& of(uint32_t accessor);  // valid until the next call

 private:
  const GltfDocument& document_;
  GltfBuffers& buffers_;
  std::map<uint32_t, uint32_t> uses_left_;  // by accessor
  std::map<uint32_t, std::vector<Position>> kept_;
  std::vector<Position> last_;
};

// Gathers the primitives of one mesh.
class GltfMeshBuilder {
 public:
  GltfMeshBuilder(const GltfDocument& document, GltfBuffers& buffers, GltfPositions& positions)
      : document_(document), buffers_(buffers), positions_(positions) {}

  // Appends a sound primitive whose mode makes triangles and which has a POSITION. Returns what about it is odd and was
  // passed over, one clause each: trailing indices that form no triangle, counts that a Draco stream contradicts.
  // Throws GltfFailure where anything that decides on the triangles is broken: non-finite positions, indices
  // out of range, and whatever accessors, views, buffers and their compression may lack.
  std::vector<std::string> append(const tinygltf::Primitive& primitive);

  size_t triangle_count() const { return mesh_.triangles.size(); }
  SourceMesh take() { return std::move(mesh_); }

 private:
  void append_plain(const tinygltf::Primitive& primitive, uint32_t position_accessor);
  void append_used(const std::vector<Position>& positions, std::vector<uint32_t>& indices);
  void append_draco(const tinygltf::Primitive& primitive, uint32_t position_accessor, const tinygltf::Value& extension);
  uint32_t append_positions(const std::vector<Position>& positions);  // returns the index of the first

  const GltfDocument& document_;
  GltfBuffers& buffers_;
  GltfPositions& positions_;
  SourceMesh mesh_;
  std::vector<std::string> odd_;
  // Where the positions of an accessor begin. Primitives often share one; repeating it for each would let a
  // small file grow without bound.
  std::map<uint32_t, uint32_t> placed_;
};

}  // namespace vcd::baker
