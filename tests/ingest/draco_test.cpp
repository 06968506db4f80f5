#include <draco/compression/encode.h>

#include <algorithm>
#include <limits>

#include "draco_encode.h"
#include "gltf_builder.h"
#include "ingest/draco_mesh.h"

namespace vcd::test {
namespace {

using namespace baker;

class DrcIngest : public GltfTest {
 protected:
  void expect_refused(const std::string& content, ErrorCode code, const std::string& reason) {
    const Result<Ingested> result = ingest(write("file.drc", content));
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().code, code) << result.error().message;
    EXPECT_NE(result.error().message.find(reason), std::string::npos) << result.error().message;
    EXPECT_NE(result.error().message.find("file.drc"), std::string::npos);
  }
};

// Triangles as their corners' positions, each begun at its least corner, all sorted: the encoder may
// renumber.
std::vector<std::array<Position, 3>> shape(const std::vector<Position>& positions,
                                           const std::vector<TriangleIndices>& triangles) {
  std::vector<std::array<Position, 3>> result;
  for (const TriangleIndices& t : triangles) {
    std::array<Position, 3> corners = {positions[t[0]], positions[t[1]], positions[t[2]]};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    result.push_back(corners);
  }
  std::sort(result.begin(), result.end());
  return result;
}

TEST_F(DrcIngest, BothMethodsGiveTheMeshBack) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    DracoInput grid = draco_grid(6);
    grid.method = method;
    const Result<Ingested> result = ingest(write("file.drc", encode_draco(grid)));
    ASSERT_TRUE(result.ok()) << result.error().message;
    ASSERT_EQ(result->meshes.size(), 1u);
    const SourceMesh& mesh = result->meshes[0];
    EXPECT_EQ(mesh.positions.size(), 49u);
    EXPECT_EQ(shape(mesh.positions, mesh.triangles), shape(grid.positions, grid.triangles));
    EXPECT_TRUE(result->notes.empty());
  }
}

TEST_F(DrcIngest, IntegerPositionsKeepTheirValues) {
  DracoInput grid = draco_grid(3);
  for (Position& p : grid.positions) p[2] = -32768;
  grid.as_int16 = true;
  const Result<Ingested> result = ingest(write("file.drc", encode_draco(grid)));
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(shape(result->meshes[0].positions, result->meshes[0].triangles), shape(grid.positions, grid.triangles));
}

TEST_F(DrcIngest, TheAttributeIsChosenByItsUniqueId) {
  DracoInput grid = draco_grid(2);
  grid.decoy = true;
  grid.position_id = 7;
  const std::string stream = encode_draco(grid);
  const std::vector<uint8_t> bytes(stream.begin(), stream.end());
  const Result<DracoMesh> chosen = decode_draco(bytes, 7);
  ASSERT_TRUE(chosen.ok()) << chosen.error().message;
  EXPECT_EQ(chosen->positions, grid.positions);
  EXPECT_EQ(decode_draco(bytes, 8)->positions, std::vector<Position>(9));
  EXPECT_FALSE(decode_draco(bytes, 9).ok());
}

TEST_F(DrcIngest, TheDensestStreamsPassTheCountCheck) {
  DracoInput grid = draco_grid(255);  // falls exactly onto the lattice of 8 bits, so every prediction is right
  grid.method = draco::MESH_EDGEBREAKER_ENCODING;
  grid.quantization_bits = 8;
  const std::string stream = encode_draco(grid);
  RecordProperty("faces_per_byte", static_cast<int>(grid.triangles.size() / stream.size()));
  EXPECT_TRUE(ingest(write("file.drc", stream)).ok());
}

TEST_F(DrcIngest, CountsThatTheBytesCannotHoldAreRefused) {
  // Header of 11 bytes, traversal type, then the number of vertices and of faces, each in one byte for so
  // small a mesh.
  DracoInput grid = draco_grid(2);
  grid.method = draco::MESH_EDGEBREAKER_ENCODING;
  std::string stream = encode_draco(grid);
  ASSERT_EQ(stream[12], 9);
  ASSERT_EQ(stream[13], 8);
  const std::string many = "\x80\x80\x80\x80\x01";  // little groups of 7 bits: 2^28
  expect_refused(stream.substr(0, 12) + many + many + stream.substr(14), ErrorCode::invalid_file,
                 "declares 268435456 faces and 268435457 points in");
}

TEST_F(DrcIngest, EveryTruncationIsRefused) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    DracoInput grid = draco_grid(3);
    grid.method = method;
    const std::string whole = encode_draco(grid);
    for (size_t size = 0; size < whole.size(); ++size) {
      const Result<Ingested> result = ingest(write("file.drc", whole.substr(0, size)));
      ASSERT_FALSE(result.ok()) << size;
      EXPECT_EQ(result.error().code, ErrorCode::invalid_file);
    }
  }
}

TEST_F(DrcIngest, OtherStreamsAreRefused) {
  expect_refused("", ErrorCode::invalid_file, "not a Draco stream");
  expect_refused("DRACE and more than eleven bytes", ErrorCode::invalid_file, "not a Draco stream");
  draco::PointCloud cloud;
  cloud.set_num_points(3);
  draco::GeometryAttribute attribute;
  attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
  const int id = cloud.AddAttribute(attribute, true, 3);
  for (uint32_t i = 0; i < 3; ++i)
    cloud.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), square[i].data());
  draco::EncoderBuffer buffer;
  ASSERT_TRUE(draco::Encoder().EncodePointCloudToBuffer(cloud, &buffer).ok());
  expect_refused(std::string(buffer.data(), buffer.size()), ErrorCode::invalid_file, "point cloud");
  expect_refused(encode_draco({.positions = square, .triangles = {}}), ErrorCode::invalid_file, "cannot be decoded");
}

TEST_F(DrcIngest, NonFinitePositionsAreNamed) {
  DracoInput grid = draco_grid(2);
  grid.positions[5][1] = std::numeric_limits<float>::quiet_NaN();
  expect_refused(encode_draco(grid), ErrorCode::invalid_file, "the position of vertex 5 is not finite");
}

// What libdraco would read is undefined: bytes of floats as truth values.
TEST_F(DrcIngest, PositionsThatClaimToBeTruthValuesAreRefused) {
  std::string stream = encode_draco(draco_grid(2));
  const std::string as_float = {draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, 0};
  const size_t at = stream.find(as_float);
  ASSERT_NE(at, std::string::npos);
  stream[at + 1] = draco::DT_BOOL;
  expect_refused(stream, ErrorCode::invalid_file, "truth values");
}

TEST_F(DrcIngest, AMissingFileIsAnIoError) {
  const Result<Ingested> result = ingest(folder_ / "nowhere.drc");
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::io);
}

}  // namespace
}  // namespace vcd::test
