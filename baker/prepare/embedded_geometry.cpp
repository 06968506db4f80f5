#include <vcd/baker/bake.h>

#include <cstring>

#include <draco/attributes/geometry_attribute.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include "ingest/draco_mesh.h"
#include "ingest/isolate.h"

namespace vcd::baker {

std::vector<std::byte> encode_geometry(const PreparedMesh& mesh) {
  draco::Mesh out;
  out.set_num_points(static_cast<uint32_t>(mesh.positions.size()));
  out.SetNumFaces(mesh.triangles.size());
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const TriangleIndices& t = mesh.triangles[i];
    out.SetFace(draco::FaceIndex(i), {draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  }
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, sizeof(Position), 0);
  const int id = out.AddAttribute(position, true, static_cast<uint32_t>(mesh.positions.size()));
  for (uint32_t i = 0; i < mesh.positions.size(); ++i)
    out.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), mesh.positions[i].data());

  draco::Encoder encoder;
  encoder.SetSpeedOptions(0, 0);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(out, &buffer).ok()) return {};
  std::vector<std::byte> bytes(buffer.size());
  std::memcpy(bytes.data(), buffer.data(), buffer.size());
  return bytes;
}

Result<SourceMesh> decode_geometry(Bytes bytes) {
  auto decoded = decode_draco({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
  if (!decoded) return decoded.error();
  SourceMesh mesh;
  mesh.positions = std::move(decoded->positions);
  mesh.triangles = std::move(decoded->triangles);
  return mesh;
}

Result<SourceMesh> decode_geometry_isolated(Bytes draco, const std::string& name) {
  auto decoded = run_isolated(name, {}, [&]() -> Result<Ingested> {
    auto mesh = decode_geometry(draco);
    if (!mesh) return Error{mesh.error().code, name + ": " + mesh.error().message};
    Ingested ingested;
    ingested.meshes.push_back(std::move(*mesh));
    return ingested;
  });
  if (!decoded) return decoded.error();
  return std::move(decoded->meshes.front());
}

}  // namespace vcd::baker
