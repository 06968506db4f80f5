// KHR_draco_mesh_compression and EXT_meshopt_compression inside glTF.
#include <meshoptimizer.h>

#include <cmath>
#include <functional>

#include "draco_encode.h"
#include "gltf_builder.h"
#include "ingest/gltf.h"
#include "ingest/gltf_meshopt.h"

namespace vcd::test {
namespace {

using namespace baker;

const std::vector<uint32_t> square_indices = {0, 1, 2, 2, 1, 3};
const std::vector<TriangleIndices> square_triangles = {{0, 1, 2}, {2, 1, 3}};

class GltfCompression : public GltfTest {
 protected:
  Result<Ingested> read(const GltfBuilder& builder) { return ingest(write("file.glb", builder.glb())); }
  void expect_refused(const GltfBuilder& builder, ErrorCode code, const std::string& reason) {
    const Result<Ingested> result = read(builder);
    ASSERT_FALSE(result.ok()) << reason;
    EXPECT_EQ(result.error().code, code) << result.error().message;
    EXPECT_NE(result.error().message.find(reason), std::string::npos) << result.error().message;
  }
};

GltfBuilder draco_file(const DracoInput& input, int component = float_type) {
  GltfBuilder builder;
  const std::string stream = encode_draco(input);
  const size_t view = builder.add_view(Bytes(stream.begin(), stream.end()));
  const size_t positions = builder.add_accessor(std::nullopt, component, "VEC3", input.positions.size());
  const size_t indices = builder.add_accessor(std::nullopt, uint32_type, "SCALAR", 3 * input.triangles.size());
  json primitive = GltfBuilder::primitive(positions, indices);
  primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view},
                                                           {"attributes", {{"POSITION", input.position_id}}}};
  builder.add_mesh({primitive}, "Draco");
  builder.document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return builder;
}

DracoInput draco_square() {
  DracoInput input;
  input.positions = square;
  input.triangles = square_triangles;
  input.position_id = 3;
  return input;
}

TEST_F(GltfCompression, DracoPrimitivesAreDecoded) {
  DracoInput input = draco_square();
  input.decoy = true;
  const Result<Ingested> result = read(draco_file(input));
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->meshes[0].name, "Draco");
  EXPECT_EQ(result->meshes[0].positions, square);
  EXPECT_EQ(result->meshes[0].triangles, square_triangles);
}

TEST_F(GltfCompression, DracoIntegersAreNormalizedByTheAccessor) {
  DracoInput input = draco_square();
  for (Position& p : input.positions) p = {p[0] * 32767, p[1] * -32768, 1};
  input.as_int16 = true;
  GltfBuilder builder = draco_file(input, int16_type);
  builder.document["extensionsUsed"] = {"KHR_mesh_quantization"};
  EXPECT_EQ(read(builder)->meshes[0].positions, input.positions);
  builder.document["accessors"][0]["normalized"] = true;
  const float small = 1 / 32767.f;
  EXPECT_EQ(read(builder)->meshes[0].positions,
            (std::vector<Position>{{0, 0, small}, {1, 0, small}, {0, -1, small}, {1, -1, small}}));
}

TEST_F(GltfCompression, DracoCountsThatDifferFromTheAccessorsCostANote) {
  const std::vector<std::string> beginnings = {
      "mesh 0 \"Draco\", primitive 0: the Draco stream holds 4 vertices, though ",
      "mesh 0 \"Draco\", primitive 0: the Draco stream holds 2 triangles, though "};
  for (const auto& [accessor, right] : {std::pair(0, 4), std::pair(1, 6)})
    for (const int count : {0, 3, 4, 6, 7, 100'000}) {
      GltfBuilder builder = draco_file(draco_square());
      builder.document["accessors"][accessor]["count"] = count;
      const Result<Ingested> result = read(builder);
      ASSERT_TRUE(result.ok()) << result.error().message;
      EXPECT_EQ(result->meshes[0].positions, square);
      EXPECT_EQ(result->meshes[0].triangles, square_triangles);
      ASSERT_EQ(result->notes.size(), count == right ? 0u : 1u) << accessor << " " << count;
      for (const std::string& note : result->notes) EXPECT_TRUE(note.starts_with(beginnings[accessor])) << note;
    }
}

TEST_F(GltfCompression, DefectsOfDracoPrimitivesAreRefused) {
  const auto refused = [&](const std::function<void(json&)>& bend, const std::string& reason) {
    GltfBuilder builder = draco_file(draco_square());
    bend(builder.document);
    expect_refused(builder, ErrorCode::invalid_file, reason);
  };
  const auto extension = [](json& d) -> json& {
    return d["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
  };
  refused([](json& d) { d["accessors"][0]["type"] = "VEC4"; }, "positions must be VEC3");
  refused([&](json& d) { extension(d)["attributes"]["POSITION"] = 44; }, "no such position attribute");
  refused([&](json& d) { extension(d).erase("attributes"); }, "has no attributes");
  refused([&](json& d) { extension(d)["bufferView"] = 1; }, "bufferView 1 does not exist");
  refused([](json& d) { d["bufferViews"][0]["byteLength"] = 20; }, "mesh 0 \"Draco\", primitive 0: ");
  refused([](json& d) { d["meshes"][0]["primitives"][0]["mode"] = 6; }, "cannot be a fan");
  refused(
      [](json& d) {
        d["accessors"][0]["componentType"] = int16_type;
        d["extensionsUsed"] = {"KHR_mesh_quantization"};
      },
      "holds float positions");
  DracoInput infinite = draco_square();
  infinite.positions[1][0] = INFINITY;
  expect_refused(draco_file(infinite), ErrorCode::invalid_file, "the position of vertex 1 is not finite");
}

template <class T>
Bytes encode_vertices(const std::vector<T>& values, size_t count, size_t stride) {
  Bytes bytes(meshopt_encodeVertexBufferBound(count, stride));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), values.data(), count, stride));
  return bytes;
}

Bytes encode_triangles(const std::vector<uint32_t>& indices) {
  Bytes bytes(meshopt_encodeIndexBufferBound(indices.size(), 4));
  bytes.resize(meshopt_encodeIndexBuffer(bytes.data(), bytes.size(), indices.data(), indices.size()));
  return bytes;
}

Bytes encode_sequence(const std::vector<uint32_t>& indices) {
  Bytes bytes(meshopt_encodeIndexSequenceBound(indices.size(), 4));
  bytes.resize(meshopt_encodeIndexSequence(bytes.data(), bytes.size(), indices.data(), indices.size()));
  return bytes;
}

// Moves the data of a view, already compressed, into the extension; what is left points into a buffer without
// data.
void compress_view(GltfBuilder& builder, size_t view, size_t count, size_t stride, const char* mode,
                   const char* extension) {
  json& object = builder.document["bufferViews"][view];
  const json compressed = {{"buffer", 0},
                           {"byteOffset", object["byteOffset"]},
                           {"byteLength", object["byteLength"]},
                           {"count", count},
                           {"byteStride", stride},
                           {"mode", mode},
                           {"filter", "NONE"}};
  object = {
      {"buffer", 1}, {"byteOffset", 0}, {"byteLength", count * stride}, {"extensions", {{extension, compressed}}}};
}

GltfBuilder meshopt_file(const char* extension = "EXT_meshopt_compression") {
  GltfBuilder builder;
  const size_t vertices = builder.add_view(encode_vertices(square, 4, 12));
  const size_t triangles = builder.add_view(encode_triangles(square_indices));
  const size_t sequence = builder.add_view(encode_sequence(square_indices));
  compress_view(builder, vertices, 4, 12, "ATTRIBUTES", extension);
  compress_view(builder, triangles, 6, 4, "TRIANGLES", extension);
  compress_view(builder, sequence, 6, 2, "INDICES", extension);
  builder.document["buffers"].push_back({{"byteLength", 1 << 20}});
  const size_t positions = builder.add_accessor(vertices, float_type, "VEC3", 4);
  builder.add_mesh({GltfBuilder::primitive(positions, builder.add_accessor(triangles, uint32_type, "SCALAR", 6))});
  builder.add_mesh({GltfBuilder::primitive(positions, builder.add_accessor(sequence, uint16_type, "SCALAR", 6))});
  builder.document["extensionsRequired"] = {extension};
  return builder;
}

json& compression_of(json& document, size_t view) {
  return document["bufferViews"][view]["extensions"]["EXT_meshopt_compression"];
}

TEST_F(GltfCompression, MeshoptViewsAreDecodedAndTheirFallbackIsNotTouched) {
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const Result<Ingested> result = read(meshopt_file(extension));
    ASSERT_TRUE(result.ok()) << result.error().message;
    ASSERT_EQ(result->meshes.size(), 2u);
    EXPECT_EQ(result->meshes[0].positions, square);
    // The triangle codec may begin a triangle at another corner; the sequence codec keeps every index.
    EXPECT_EQ(result->meshes[0].triangles.size(), 2u);
    EXPECT_EQ(result->meshes[1].triangles, square_triangles);
  }
}

TEST_F(GltfCompression, TheExponentialFilterAppliesToPositions) {
  GltfBuilder builder = meshopt_file();
  std::vector<float> values;
  for (const Position& p : square) values.insert(values.end(), {p[0] * 0.75f, p[1] * -3.5f, 1024});
  std::vector<uint32_t> encoded(values.size());
  meshopt_encodeFilterExp(encoded.data(), 4, 12, 15, values.data());
  const size_t vertices = builder.add_view(encode_vertices(encoded, 4, 12));
  compress_view(builder, vertices, 4, 12, "ATTRIBUTES", "EXT_meshopt_compression");
  compression_of(builder.document, vertices)["filter"] = "EXPONENTIAL";
  builder.document["accessors"][0]["bufferView"] = vertices;
  const Result<Ingested> result = read(builder);
  ASSERT_TRUE(result.ok()) << result.error().message;
  for (size_t i = 0; i < values.size(); ++i) EXPECT_EQ(result->meshes[0].positions[i / 3][i % 3], values[i]);
}

TEST_F(GltfCompression, TheOtherFiltersAreUndone) {
  struct Case {
    const char* name;
    size_t stride;
    void (*undo)(void*, size_t, size_t);
  };
  for (const Case& c : {Case{"OCTAHEDRAL", 4, meshopt_decodeFilterOct}, Case{"OCTAHEDRAL", 8, meshopt_decodeFilterOct},
                        Case{"QUATERNION", 8, meshopt_decodeFilterQuat}}) {
    const size_t count = 2;
    const std::vector<float> unit = {0.6f, 0, 0.8f, 0, 0, 1, 0, 0};  // two vectors, or two quaternions
    Bytes filtered(count * c.stride);
    if (c.undo == meshopt_decodeFilterOct) {
      meshopt_encodeFilterOct(filtered.data(), count, c.stride, 8, unit.data());
    } else {
      meshopt_encodeFilterQuat(filtered.data(), count, c.stride, 12, unit.data());
    }
    const Bytes compressed = encode_vertices(filtered, count, c.stride);
    using tinygltf::Value;
    const Value extension(Value::Object{{"count", Value(static_cast<int>(count))},
                                        {"byteStride", Value(static_cast<int>(c.stride))},
                                        {"mode", Value(std::string("ATTRIBUTES"))},
                                        {"filter", Value(std::string(c.name))}});
    const Bytes decoded = decode_meshopt({&extension, "view"}, compressed);
    Bytes expected = filtered;
    c.undo(expected.data(), count, c.stride);
    EXPECT_EQ(decoded, expected) << c.name;
    EXPECT_NE(decoded, filtered) << c.name;
  }
}

TEST_F(GltfCompression, DefectsOfMeshoptViewsAreRefused) {
  const auto refused = [&](size_t view, const char* key, const json& value, ErrorCode code, const std::string& reason) {
    SCOPED_TRACE(reason);
    GltfBuilder builder = meshopt_file();
    compression_of(builder.document, view)[key] = value;
    expect_refused(builder, code, reason);
  };
  const ErrorCode invalid = ErrorCode::invalid_file;
  const ErrorCode unsupported = ErrorCode::unsupported;
  refused(0, "mode", "WAVELETS", unsupported, "mode \"WAVELETS\" is not known");
  refused(0, "filter", "COLOR", unsupported, "filter \"COLOR\" is not known");
  refused(0, "filter", "OCTAHEDRAL", invalid, "needs a byteStride of 4 or 8");
  refused(0, "filter", "QUATERNION", invalid, "needs a byteStride of 8");
  refused(1, "filter", "EXPONENTIAL", invalid, "in mode ATTRIBUTES only");
  refused(0, "byteStride", 6, invalid, "byteStride 6 is not allowed");
  refused(0, "byteStride", 260, invalid, "byteStride 260 is not allowed");
  refused(1, "byteStride", 8, invalid, "byteStride 8 is not allowed");
  refused(0, "count", 0, invalid, "count is 0");
  refused(1, "count", 7, invalid, "not a multiple of 3");
  refused(0, "count", uint64_t{1} << 40, invalid, "count is above 2^32 - 1");
  refused(1, "count", 3 << 20, invalid, "cannot hold");
  refused(2, "count", 1 << 20, invalid, "cannot hold");
  refused(0, "count", 3, invalid, "differs from the 36 bytes");
  refused(0, "byteLength", 10, invalid, "corrupt");
  refused(0, "byteLength", 1 << 20, invalid, "of the buffer");
  refused(0, "buffer", 1, ErrorCode::io, "buffer 1: has no uri");
}

TEST_F(GltfCompression, ANewerVertexCodecIsUnsupported) {
  GltfBuilder builder = meshopt_file();
  Bytes newer = encode_vertices(square, 4, 12);
  newer[0] = 0xA1;
  const size_t view = builder.add_view(newer);
  compress_view(builder, view, 4, 12, "ATTRIBUTES", "EXT_meshopt_compression");
  builder.document["accessors"][0]["bufferView"] = view;
  expect_refused(builder, ErrorCode::unsupported, "version 1 of the vertex codec");
}

}  // namespace
}  // namespace vcd::test
