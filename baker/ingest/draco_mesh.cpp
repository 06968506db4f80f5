#include "ingest/draco_mesh.h"

#include <draco/compression/decode.h>

#include <array>
#include <cmath>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "ingest/check.h"
#include "ingest/draco_counts.h"
#include "ingest/text.h"

namespace vcd::baker {

namespace {

Error invalid(std::string message) { return {ErrorCode::invalid_file, std::move(message)}; }

draco::DecoderBuffer buffer_over(std::span<const uint8_t> bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return buffer;
}

std::optional<Error> check_header(std::span<const uint8_t> bytes) {
  draco::DecoderBuffer type_buffer = buffer_over(bytes);
  const auto type = draco::Decoder::GetEncodedGeometryType(&type_buffer);
  if (!type.ok()) return invalid("not a Draco stream: " + type.status().error_msg_string());
  if (type.value() == draco::POINT_CLOUD) return invalid("a Draco point cloud: it has no triangle");
  draco::DecoderBuffer count_buffer = buffer_over(bytes);
  const std::optional<DracoCounts> counts = read_draco_counts(count_buffer);
  if (!counts) return invalid("the header of the Draco stream is corrupt");
  if (plausible(*counts, bytes.size())) return std::nullopt;
  return invalid("the Draco stream declares " + std::to_string(counts->faces) + " faces and " +
                 std::to_string(counts->points) + " points in " + std::to_string(bytes.size()) + " bytes");
}

// Integers are read as such: libdraco would scale the normalized ones by a rule of its own.
bool read_position(const draco::PointAttribute& attribute, draco::AttributeValueIndex value, bool as_integers,
                   Position& position) {
  if (!as_integers) return attribute.ConvertValue<float, 3>(value, position.data());
  std::array<int32_t, 3> integers;
  if (!attribute.ConvertValue<int32_t, 3>(value, integers.data())) return false;
  for (size_t axis = 0; axis < 3; ++axis) position[axis] = static_cast<float>(integers[axis]);
  return true;
}

Result<std::vector<Position>> read_positions(const draco::Mesh& mesh, const draco::PointAttribute& attribute) {
  if (attribute.num_components() != 3) return invalid("the Draco position attribute has not 3 components");
  // libdraco would read any byte as a bool, which is undefined.
  if (attribute.data_type() == draco::DT_BOOL) return invalid("the Draco positions are truth values");
  const bool as_integers = draco::IsDataTypeIntegral(attribute.data_type());
  std::vector<Position> positions(mesh.num_points());
  for (uint32_t point = 0; point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(point));
    if (value.value() >= attribute.size() || !read_position(attribute, value, as_integers, positions[point])) {
      return invalid("Draco point " + std::to_string(point) + " has no position");
    }
  }
  return positions;
}

Result<std::vector<TriangleIndices>> read_triangles(const draco::Mesh& mesh) {
  std::vector<TriangleIndices> triangles(mesh.num_faces());
  for (uint32_t face = 0; face < mesh.num_faces(); ++face) {
    const draco::Mesh::Face& corners = mesh.face(draco::FaceIndex(face));
    for (size_t corner = 0; corner < 3; ++corner) {
      const uint32_t point = corners[corner].value();
      if (point >= mesh.num_points()) {
        return invalid("Draco face " + std::to_string(face) + " names point " + std::to_string(point) + ", there are " +
                       std::to_string(mesh.num_points()));
      }
      triangles[face][corner] = point;
    }
  }
  return triangles;
}

// The first thing that keeps the decoded mesh from being one of ours; empty if nothing does.
std::string fault_of(const DracoMesh& mesh) {
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const Position& p = mesh.positions[i];
    if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) continue;
    return "the position of vertex " + std::to_string(i) + " is not finite";
  }
  return mesh.triangles.empty() ? "no triangle: the Draco mesh has no face" : "";
}

}  // namespace

Result<DracoMesh> decode_draco(std::span<const uint8_t> bytes, std::optional<uint32_t> position_id) {
  if (std::optional<Error> error = check_header(bytes)) return std::move(*error);
  draco::DecoderBuffer buffer = buffer_over(bytes);
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    const bool newer = decoded.status().code() == draco::Status::UNSUPPORTED_VERSION ||
                       decoded.status().code() == draco::Status::UNKNOWN_VERSION;
    return Error{newer ? ErrorCode::unsupported : ErrorCode::invalid_file,
                 "the Draco stream cannot be decoded: " + decoded.status().error_msg_string()};
  }
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  const draco::PointAttribute* attribute = position_id ? mesh->GetAttributeByUniqueId(*position_id)
                                                       : mesh->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (attribute == nullptr) return invalid("the Draco mesh has no such position attribute");
  Result<std::vector<Position>> positions = read_positions(*mesh, *attribute);
  if (!positions) return positions.error();
  Result<std::vector<TriangleIndices>> triangles = read_triangles(*mesh);
  if (!triangles) return triangles.error();
  return DracoMesh{std::move(*positions), std::move(*triangles), draco::IsDataTypeIntegral(attribute->data_type())};
}

Result<Ingested> ingest_drc(const std::filesystem::path& path, std::string_view bytes, const IngestOptions&) try {
  Result<DracoMesh> mesh = decode_draco({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
  if (!mesh) return file_error(path, mesh.error().code, mesh.error().message);
  const std::string fault = fault_of(*mesh);
  if (!fault.empty()) return file_error(path, ErrorCode::invalid_file, fault);
  Ingested ingested;
  ingested.meshes.push_back({path.stem().string(), 0, std::move(mesh->positions), std::move(mesh->triangles)});
  return ingested;
} catch (const std::bad_alloc&) {
  return file_error(path, ErrorCode::runtime, "out of memory while reading");
} catch (const std::exception& failure) {
  return file_error(path, ErrorCode::runtime, std::string("the parser failed: ") + failure.what());
}

}  // namespace vcd::baker
