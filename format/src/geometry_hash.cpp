#include <vcd/format/geometry_hash.h>

#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <xxhash.h>

namespace vcd {
namespace {

uint32_t index_at(const std::byte* at, uint32_t size) {
  uint32_t wide = 0;
  std::memcpy(&wide, at, size);  // little-endian: layout.h
  return wide;
}

Result<GeometryHash> hash_of(std::vector<Position>&& positions, std::vector<TriangleIndices>&& triangles) {
  if (!is_sound(positions, triangles))
    return Error{ErrorCode::usage, "mesh: a position is not finite, or an index is too large"};
  const WeldedMesh mesh = weld(std::move(positions), std::move(triangles));
  if (mesh.triangles.empty()) return Error{ErrorCode::invalid_file, "mesh: no triangle with an area"};
  return geometry_hash(mesh);
}

// Memory can be short.
template <class Run>
Result<GeometryHash> guarded(Run&& run) {
  try {
    return run();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::runtime, "mesh: out of memory"};
  }
}

}  // namespace

std::vector<Position> positions_of(const PositionBuffer& buffer) {
  std::vector<Position> positions(buffer.count);
  const auto* first = static_cast<const std::byte*>(buffer.first);
  for (size_t i = 0; i < buffer.count; ++i) std::memcpy(&positions[i], first + i * buffer.stride, sizeof(Position));
  return positions;
}

Result<std::vector<TriangleIndices>> triangles_of(const IndexBuffer& faces) {
  if ((faces.corners != 3 && faces.corners != 4) || (faces.index_size != 2 && faces.index_size != 4))
    return Error{ErrorCode::usage, "faces: they have 3 or 4 corners, and indices of 2 or 4 bytes"};
  std::vector<TriangleIndices> triangles;
  triangles.reserve(faces.count * (faces.corners - 2));
  const size_t stride = faces.stride ? faces.stride : size_t{faces.corners} * faces.index_size;
  const auto* face = static_cast<const std::byte*>(faces.first);
  for (size_t i = 0; i < faces.count; ++i, face += stride) {
    const auto corner = [&](uint32_t n) { return index_at(face + size_t{n} * faces.index_size, faces.index_size); };
    if (faces.corners == 3) {
      triangles.push_back({corner(0), corner(1), corner(2)});
    } else {
      triangles.push_back({corner(0), corner(1), corner(3)});
      triangles.push_back({corner(2), corner(3), corner(1)});
    }
  }
  return triangles;
}

Result<GeometryHash> geometry_hash(const PositionBuffer& positions, const IndexBuffer& faces) {
  return guarded([&]() -> Result<GeometryHash> {
    auto triangles = triangles_of(faces);
    if (!triangles) return triangles.error();
    return hash_of(positions_of(positions), std::move(*triangles));
  });
}

Result<GeometryHash> geometry_hash(std::span<const Position> positions, std::span<const TriangleIndices> triangles) {
  return guarded([&] { return hash_of({positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}); });
}

GeometryHash geometry_hash(const WeldedMesh& mesh) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), XXH3_freeState);
  if (!state) throw std::bad_alloc();
  XXH3_128bits_reset(state.get());
  const uint64_t counts[2] = {mesh.positions.size(), mesh.triangles.size()};
  XXH3_128bits_update(state.get(), counts, sizeof counts);
  XXH3_128bits_update(state.get(), mesh.positions.data(), mesh.positions.size() * sizeof(Position));
  XXH3_128bits_update(state.get(), mesh.triangles.data(), mesh.triangles.size() * sizeof(TriangleIndices));
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state.get()));
  return std::to_array(canonical.digest);
}

}  // namespace vcd
