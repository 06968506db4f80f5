#include <vcd/baker/bake.h>

#include <cstring>

#include <draco/attributes/geometry_attribute.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

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

}  // namespace vcd::baker
