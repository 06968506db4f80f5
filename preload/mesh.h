// A mesh as the program gave it to Embree.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include <embree3/rtcore.h>
#include <vcd/format/geometry_hash.h>

namespace vcd::preload {

// A buffer of the program's, which may change it until the next commit.
struct Buffer {
  const std::byte* first = nullptr;
  RTCFormat format = RTC_FORMAT_UNDEFINED;
  size_t stride = 0, count = 0;
};

struct Mesh {
  Buffer positions, faces;
  uint32_t corners = 3;  // or 4
};

// Whether the buffers are of the kinds that geometry_hash() takes.
bool is_plain(const Mesh& mesh);

GeometryHash fingerprint_of(const Mesh& mesh);  // of the items' bytes: fast, and changes where any does
Result<GeometryHash> geometry_hash_of(const Mesh& mesh);

std::string to_hex(const GeometryHash& hash);

// Writes FOLDER/HASH.ply, which vc-bake gives the same hash, unless it is there already.
std::optional<Error> export_mesh(const Mesh& mesh, const GeometryHash& hash, const std::filesystem::path& folder);

}  // namespace vcd::preload
