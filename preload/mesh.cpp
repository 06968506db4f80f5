#include "mesh.h"

#include <array>
#include <atomic>
#include <cstring>
#include <fstream>
#include <memory>
#include <new>
#include <system_error>

#include <unistd.h>
#include <xxhash.h>

namespace vcd::preload {
namespace {

size_t size_of_face(const Mesh& mesh) { return mesh.corners * sizeof(uint32_t); }

void add(XXH3_state_t& state, const Buffer& buffer, size_t item_size) {
  const size_t shape[2] = {buffer.stride, buffer.count};
  XXH3_128bits_update(&state, shape, sizeof shape);
  if (buffer.stride == item_size) return void(XXH3_128bits_update(&state, buffer.first, buffer.count * item_size));
  // What lies between the items is not promised to stay as it is.
  for (size_t i = 0; i < buffer.count; ++i) XXH3_128bits_update(&state, buffer.first + i * buffer.stride, item_size);
}

template <class Item>
Item item(const Buffer& buffer, size_t i) {
  Item copy;
  std::memcpy(&copy, buffer.first + i * buffer.stride, sizeof copy);
  return copy;
}

void write_triangle(std::ostream& out, uint32_t a, uint32_t b, uint32_t c) {
  const uint32_t corners[3] = {a, b, c};
  out.put(3);
  out.write(reinterpret_cast<const char*>(corners), sizeof corners);
}

// Quads are cut as Embree and geometry_hash() cut them.
void write_ply(std::ostream& out, const Mesh& mesh) {
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.positions.count
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
      << mesh.faces.count * (mesh.corners - 2) << "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (size_t i = 0; i < mesh.positions.count; ++i)
    out.write(reinterpret_cast<const char*>(mesh.positions.first + i * mesh.positions.stride), sizeof(Position));
  for (size_t i = 0; i < mesh.faces.count; ++i) {
    if (mesh.corners == 3) {
      const auto [a, b, c] = item<std::array<uint32_t, 3>>(mesh.faces, i);
      write_triangle(out, a, b, c);
    } else {
      const auto [a, b, c, d] = item<std::array<uint32_t, 4>>(mesh.faces, i);
      write_triangle(out, a, b, d);
      write_triangle(out, c, d, b);
    }
  }
}

}  // namespace

bool is_plain(const Mesh& mesh) {
  return mesh.positions.first && mesh.positions.format == RTC_FORMAT_FLOAT3 && mesh.faces.first &&
         mesh.faces.format == (mesh.corners == 3 ? RTC_FORMAT_UINT3 : RTC_FORMAT_UINT4);
}

GeometryHash fingerprint_of(const Mesh& mesh) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), XXH3_freeState);
  if (!state) throw std::bad_alloc();
  XXH3_128bits_reset(state.get());
  XXH3_128bits_update(state.get(), &mesh.corners, sizeof mesh.corners);
  add(*state, mesh.positions, sizeof(Position));
  add(*state, mesh.faces, size_of_face(mesh));
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state.get()));
  return std::to_array(canonical.digest);
}

Result<GeometryHash> geometry_hash_of(const Mesh& mesh) {
  return geometry_hash(
      PositionBuffer{mesh.positions.first, mesh.positions.count, mesh.positions.stride},
      IndexBuffer{mesh.faces.first, mesh.faces.count, mesh.corners, sizeof(uint32_t), mesh.faces.stride});
}

std::string to_hex(const GeometryHash& hash) {
  std::string text;
  for (const uint8_t byte : hash) text += "0123456789abcdef"[byte >> 4], text += "0123456789abcdef"[byte & 15];
  return text;
}

std::optional<Error> export_mesh(const Mesh& mesh, const GeometryHash& hash, const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / (to_hex(hash) + ".ply");
  std::error_code error;
  if (std::filesystem::exists(path, error)) return std::nullopt;
  std::filesystem::create_directories(folder, error);
  // A name of its own until it is whole: other threads and processes export too, and vc-bake may be reading the folder.
  static std::atomic<uint64_t> exports = 0;
  const std::filesystem::path part =
      folder / (to_hex(hash) + "." + std::to_string(getpid()) + "." + std::to_string(++exports) + ".part");
  std::ofstream out(part, std::ios::binary);
  write_ply(out, mesh);
  out.close();
  if (out) std::filesystem::rename(part, path, error);
  if (out && !error) return std::nullopt;
  std::filesystem::remove(part, error);
  return Error{ErrorCode::io, path.string() + ": cannot be written"};
}

}  // namespace vcd::preload
