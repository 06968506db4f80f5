#include "ingest/gltf_primitive.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "ingest/draco_mesh.h"
#include "ingest/gltf_accessor.h"

namespace vcd::baker {

namespace {

void check_finite(const std::vector<Position>& positions, uint32_t accessor) {
  for (size_t i = 0; i < positions.size(); ++i) {
    const Position& p = positions[i];
    if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) continue;
    fail_invalid("the position of vertex " + std::to_string(i) + " is not finite (accessor " +
                 std::to_string(accessor) + ")");
  }
}

void check_in_range(const std::vector<uint32_t>& indices, uint32_t vertex_count, uint32_t accessor) {
  for (size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] < vertex_count) continue;
    fail_invalid("index element " + std::to_string(i) + " is " + std::to_string(indices[i]) + ", there are " +
                 std::to_string(vertex_count) + " vertices (accessor " + std::to_string(accessor) + ")");
  }
}

// Corners as the specification numbers them, which keeps the winding of every triangle.
TriangleIndices corners_of(GltfMode mode, uint32_t triangle) {
  const uint32_t t = triangle;
  if (mode == GltfMode::triangle_strip) return {t, t + 1 + t % 2, t + 2 - t % 2};
  if (mode == GltfMode::triangle_fan) return {t + 1, t + 2, 0};
  return {3 * t, 3 * t + 1, 3 * t + 2};
}

uint32_t triangle_count_of(GltfMode mode, size_t index_count) {
  if (index_count < 3) return 0;
  const size_t count = mode == GltfMode::triangles ? index_count / 3 : index_count - 2;
  if (index_count > UINT32_MAX) fail_gltf(ErrorCode::unsupported, "more than 2^32 indices in one primitive");
  return static_cast<uint32_t>(count);
}

}  // namespace

GltfMode mode_of(const tinygltf::Primitive& primitive) { return static_cast<GltfMode>(primitive.mode); }

bool makes_triangles(GltfMode mode) { return mode >= GltfMode::triangles; }

GltfPositions::GltfPositions(const GltfDocument& document, GltfBuffers& buffers)
    : document_(document), buffers_(buffers) {
  for (const tinygltf::Mesh& mesh : document.model().meshes) {
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      const auto position = primitive.attributes.find("POSITION");
      if (position != primitive.attributes.end()) ++uses_left_[static_cast<uint32_t>(position->second)];
    }
  }
}

const std::vector<Position>& GltfPositions::of(uint32_t accessor) {
  auto kept = kept_.find(accessor);
  if (kept == kept_.end()) {
    kept = kept_.emplace(accessor, read_positions(document_, buffers_, accessor)).first;
    check_finite(kept->second, accessor);
  }
  uint32_t& uses_left = uses_left_[accessor];
  if (uses_left > 1) {
    --uses_left;
    return kept->second;
  }
  last_ = std::move(kept->second);
  kept_.erase(kept);
  return last_;
}

std::vector<std::string> GltfMeshBuilder::append(const tinygltf::Primitive& primitive) {
  odd_.clear();
  const auto positions = static_cast<uint32_t>(primitive.attributes.at("POSITION"));
  const auto draco = primitive.extensions.find("KHR_draco_mesh_compression");
  if (draco != primitive.extensions.end()) append_draco(primitive, positions, draco->second);
  else append_plain(primitive, positions);
  return std::move(odd_);
}

void GltfMeshBuilder::append_plain(const tinygltf::Primitive& primitive, uint32_t position_accessor) {
  const std::vector<Position>& positions = positions_.of(position_accessor);
  std::vector<uint32_t> indices;
  if (primitive.indices >= 0) {
    const auto index_accessor = static_cast<uint32_t>(primitive.indices);
    indices = read_indices(document_, buffers_, index_accessor);
    check_in_range(indices, static_cast<uint32_t>(positions.size()), index_accessor);
  } else {
    indices.resize(positions.size());
    std::iota(indices.begin(), indices.end(), 0u);
  }
  uint32_t first = 0;
  const auto placed = placed_.find(position_accessor);
  if (placed != placed_.end()) {
    first = placed->second;
  } else if (indices.size() < positions.size() / 4) {
    append_used(positions, indices);
  } else {
    first = placed_[position_accessor] = append_positions(positions);
  }
  const GltfMode mode = mode_of(primitive);
  const uint32_t count = triangle_count_of(mode, indices.size());
  mesh_.triangles.reserve(mesh_.triangles.size() + count);
  for (uint32_t triangle = 0; triangle < count; ++triangle) {
    TriangleIndices corners = corners_of(mode, triangle);
    for (uint32_t& corner : corners) corner = first + indices[corner];
    mesh_.triangles.push_back(corners);
  }
  const size_t unused = mode == GltfMode::triangles ? indices.size() % 3 : count == 0 ? indices.size() : 0;
  if (unused > 0) odd_.push_back("the last " + std::to_string(unused) + " of its vertices form no triangle");
}

// Appends the positions that the indices name, and makes the indices name those: so the cost is that of what is used.
void GltfMeshBuilder::append_used(const std::vector<Position>& positions, std::vector<uint32_t>& indices) {
  std::vector<uint32_t> used = indices;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::vector<Position> kept;
  kept.reserve(used.size());
  for (const uint32_t index : used) kept.push_back(positions[index]);
  const uint32_t first = append_positions(kept);
  for (uint32_t& index : indices)
    index = first + static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), index) - used.begin());
}

void GltfMeshBuilder::append_draco(const tinygltf::Primitive& primitive, uint32_t position_accessor,
                                   const tinygltf::Value& extension) {
  if (mode_of(primitive) == GltfMode::triangle_fan) fail_invalid("Draco data cannot be a fan");
  const GltfPositionAccessor declared = check_position_accessor(document_, position_accessor);
  const GltfView view = buffers_.view(number_in(extension, "bufferView"));
  const uint32_t id = number_in(extension.Get("attributes"), "POSITION");
  Result<DracoMesh> decoded = decode_draco(view.bytes, id);
  if (!decoded) fail_gltf(decoded.error().code, decoded.error().message);
  std::vector<Position>& positions = decoded->positions;
  if (positions.size() != declared.count) {
    odd_.push_back("the Draco stream holds " + std::to_string(positions.size()) + " vertices, though accessor " +
                   std::to_string(position_accessor) + " declares " + std::to_string(declared.count) +
                   "; those of the stream taken");
  }
  if (primitive.indices >= 0 && mode_of(primitive) == GltfMode::triangles) {
    const uint64_t index_count = check_index_accessor(document_, static_cast<uint32_t>(primitive.indices));
    if (index_count != 3 * uint64_t{decoded->triangles.size()}) {
      odd_.push_back("the Draco stream holds " + std::to_string(decoded->triangles.size()) +
                     " triangles, though accessor " + std::to_string(primitive.indices) + " declares " +
                     std::to_string(index_count) + " indices; those of the stream taken");
    }
  }
  const bool declared_as_integers = declared.type.component != TINYGLTF_COMPONENT_TYPE_FLOAT;
  if (declared_as_integers && !decoded->integer_positions) {
    fail_invalid("the Draco stream holds float positions, accessor " + std::to_string(position_accessor) +
                 " declares integers");
  }
  for (Position& position : positions) {
    for (float& coordinate : position) coordinate = dequantize(coordinate, declared.type);
  }
  check_finite(positions, position_accessor);
  const uint32_t first = append_positions(positions);
  for (const TriangleIndices& corners : decoded->triangles) {
    mesh_.triangles.push_back({first + corners[0], first + corners[1], first + corners[2]});
  }
}

uint32_t GltfMeshBuilder::append_positions(const std::vector<Position>& positions) {
  const size_t first = mesh_.positions.size();
  if (positions.size() > UINT32_MAX - first) fail_gltf(ErrorCode::unsupported, "more than 2^32 vertices in one mesh");
  mesh_.positions.insert(mesh_.positions.end(), positions.begin(), positions.end());
  return static_cast<uint32_t>(first);
}

}  // namespace vcd::baker
