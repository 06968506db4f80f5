// Draco streams made in code, for tests.
#pragma once

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <vcd/baker/mesh.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace vcd::test {

struct DracoInput {
  std::vector<baker::Position> positions;
  std::vector<baker::TriangleIndices> triangles;
  int method = draco::MESH_SEQUENTIAL_ENCODING;
  int quantization_bits = 0;  // 0: floats as they are
  bool as_int16 = false;      // store positions as 16-bit integers
  uint32_t position_id = 0;   // unique id of the position attribute
  bool decoy = false;         // a second attribute of type POSITION, all zeros, comes first
};

template <class T>
void add_attribute(draco::Mesh& mesh, draco::DataType type, uint32_t unique_id,
                   const std::vector<std::array<T, 3>>& values) {
  draco::GeometryAttribute attribute;
  // Integers are marked as normalized, which must not scale them: the accessor of the glTF decides on that.
  const bool normalized = type != draco::DT_FLOAT32;
  attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, type, normalized, sizeof(T) * 3, 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<uint32_t>(values.size()));
  mesh.attribute(id)->set_unique_id(unique_id);
  for (uint32_t i = 0; i < values.size(); ++i) {
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), values[i].data());
  }
}

inline std::string encode_draco(const DracoInput& input) {
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<uint32_t>(input.positions.size()));
  if (input.decoy) {
    add_attribute(mesh, draco::DT_FLOAT32, input.position_id + 1, std::vector<baker::Position>(input.positions.size()));
  }
  if (input.as_int16) {
    std::vector<std::array<int16_t, 3>> integers;
    for (const baker::Position& p : input.positions) {
      integers.push_back({static_cast<int16_t>(p[0]), static_cast<int16_t>(p[1]), static_cast<int16_t>(p[2])});
    }
    add_attribute(mesh, draco::DT_INT16, input.position_id, integers);
  } else {
    add_attribute(mesh, draco::DT_FLOAT32, input.position_id, input.positions);
  }
  for (const baker::TriangleIndices& t : input.triangles) {
    mesh.AddFace({draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  }
  draco::ExpertEncoder encoder(mesh);
  encoder.SetSpeedOptions(0, 0);  // the smallest stream
  encoder.SetEncodingMethod(input.method);
  if (input.quantization_bits > 0) encoder.SetAttributeQuantization(0, input.quantization_bits);
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  return status.ok() ? std::string(buffer.data(), buffer.size()) : "";
}

// A flat grid of n by n squares, the kind of mesh that compresses best.
inline DracoInput draco_grid(uint32_t n) {
  DracoInput grid;
  for (uint32_t y = 0; y <= n; ++y) {
    for (uint32_t x = 0; x <= n; ++x) grid.positions.push_back({static_cast<float>(x), static_cast<float>(y), 0});
  }
  for (uint32_t y = 0; y < n; ++y) {
    for (uint32_t x = 0; x < n; ++x) {
      const uint32_t corner = y * (n + 1) + x;
      grid.triangles.push_back({corner, corner + 1, corner + n + 1});
      grid.triangles.push_back({corner + n + 1, corner + 1, corner + n + 2});
    }
  }
  return grid;
}

}  // namespace vcd::test
