#include "ingest/draco_counts.h"

#include <draco/compression/config/compression_shared.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/decoder_buffer.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/geometry_metadata.h>
#include <draco/metadata/metadata_decoder.h>

namespace vcd::baker {

namespace {

constexpr uint16_t version(uint8_t major, uint8_t minor) { return static_cast<uint16_t>(major << 8 | minor); }

// Counts became variable-length in one version or another, depending on the method.
std::optional<uint32_t> read_count(draco::DecoderBuffer& buffer, bool variable_length) {
  uint32_t count = 0;
  const bool ok = variable_length ? draco::DecodeVarint(&count, &buffer) : buffer.Decode(&count);
  return ok ? std::optional(count) : std::nullopt;
}

std::optional<DracoCounts> read_sequential(draco::DecoderBuffer& buffer, uint16_t stream_version) {
  const bool variable_length = stream_version >= version(2, 2);
  const auto faces = read_count(buffer, variable_length);
  const auto points = read_count(buffer, variable_length);
  if (!faces || !points) return std::nullopt;
  return DracoCounts{*faces, *points};
}

std::optional<DracoCounts> read_edgebreaker(draco::DecoderBuffer& buffer, uint16_t stream_version) {
  const bool variable_length = stream_version >= version(2, 0);
  uint8_t traversal = 0;
  if (!buffer.Decode(&traversal)) return std::nullopt;
  std::optional<uint32_t> new_vertices = 0;
  if (stream_version < version(2, 2)) new_vertices = read_count(buffer, variable_length);
  const auto vertices = read_count(buffer, variable_length);
  const auto faces = read_count(buffer, variable_length);
  uint8_t attribute_data = 0;
  if (!buffer.Decode(&attribute_data)) return std::nullopt;
  const auto symbols = read_count(buffer, variable_length);
  const auto split_symbols = read_count(buffer, variable_length);
  if (!new_vertices || !vertices || !faces || !symbols || !split_symbols) return std::nullopt;
  return DracoCounts{*faces, uint64_t{*vertices} + *new_vertices + *split_symbols};
}

}  // namespace

std::optional<DracoCounts> read_draco_counts(draco::DecoderBuffer& buffer) {
  draco::DracoHeader header;
  if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) return std::nullopt;
  const uint16_t stream_version = version(header.version_major, header.version_minor);
  buffer.set_bitstream_version(stream_version);
  if (stream_version >= version(1, 3) && (header.flags & METADATA_FLAG_MASK) != 0) {
    draco::GeometryMetadata metadata;
    if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata)) return std::nullopt;
  }
  if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING) return read_sequential(buffer, stream_version);
  if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING) return read_edgebreaker(buffer, stream_version);
  return std::nullopt;
}

bool plausible(const DracoCounts& counts, size_t stream_bytes) {
  constexpr uint64_t elements_per_byte = 4096;
  const uint64_t most = stream_bytes * elements_per_byte;
  return counts.faces <= most && counts.points <= most;
}

}  // namespace vcd::baker
