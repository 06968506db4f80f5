// Draco bitstreams: bare .drc files, and the payload of glTF's KHR_draco_mesh_compression.
#pragma once

#include <vcd/baker/ingest.h>
#include <vcd/baker/mesh.h>
#include <vcd/format/error.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace vcd::baker {

struct DracoMesh {
  std::vector<Position> positions;         // one a Draco point; finite or not
  std::vector<TriangleIndices> triangles;  // each index below positions.size()
  bool integer_positions = false;          // stored as integers; positions holds their plain values
};

// Decodes a mesh with libdraco.
//
// The counts in the header are compared with the number of bytes first, so that a handful of bytes cannot ask
// for gigabytes. libdraco itself is not safe on hostile bytes: run this in a process that may die. Errors:
// invalid_file (not Draco, corrupt, a point cloud, no position), unsupported (a newer bitstream).
// position_id: unique id of the attribute to take; by default the first of type POSITION.
Result<DracoMesh> decode_draco(std::span<const uint8_t> bytes, std::optional<uint32_t> position_id = std::nullopt);

// Reads a .drc file as one mesh; see ingest().
Result<Ingested> ingest_drc(const std::filesystem::path& path, std::string_view bytes, const IngestOptions& options);

}  // namespace vcd::baker
