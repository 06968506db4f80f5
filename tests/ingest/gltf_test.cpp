#include "ingest/gltf.h"

#include <limits>

#include "gltf_builder.h"
#include "mesh_files.h"

namespace vcd::test {
namespace {

using namespace baker;

const Triangles square_triangles = {{0, 1, 2}, {2, 1, 3}};

class GltfIngest : public GltfTest {
 protected:
  Ingested read(const std::string& content, const IngestOptions& options = {}) {
    const Result<Ingested> result = ingest(write("file.gltf", content), options);
    if (!result) {
      ADD_FAILURE() << result.error().message;
      return {};
    }
    return *result;
  }
  SourceMesh read_one(const GltfBuilder& builder, const IngestOptions& options = {}) {
    const Ingested ingested = read(builder.embedded(), options);
    EXPECT_EQ(ingested.meshes.size(), 1u);
    return ingested.meshes.empty() ? SourceMesh{} : ingested.meshes[0];
  }
};

TEST_F(GltfIngest, OneMeshPerGltfMeshWhicheverNodesUseIt) {
  GltfBuilder builder = square_file();
  builder.add_mesh({builder.document["meshes"][0]["primitives"][0]}, "Gr\xC3\xBCn \xE7\xBB\xBF");
  builder.add_mesh({builder.document["meshes"][0]["primitives"][0]});
  builder.document["nodes"] = {{{"mesh", 1}, {"scale", {-1, 1, 1}}}, {{"mesh", 1}, {"translation", {5, 0, 0}}}};
  const Ingested ingested = read(builder.embedded());
  ASSERT_EQ(ingested.meshes.size(), 3u);
  EXPECT_EQ(ingested.meshes[0].name, "Square");
  EXPECT_EQ(ingested.meshes[1].name, "Gr\xC3\xBCn \xE7\xBB\xBF");
  EXPECT_EQ(ingested.meshes[2].name, "");
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(ingested.meshes[i].source_index, i);
    EXPECT_EQ(ingested.meshes[i].positions, square);
    EXPECT_EQ(ingested.meshes[i].triangles, square_triangles);
  }
  EXPECT_TRUE(ingested.notes.empty());
}

TEST_F(GltfIngest, PrimitivesAreConcatenatedAndSharedPositionsStoredOnce) {
  GltfBuilder builder;
  const size_t first = builder.add_positions(square);
  const size_t second = builder.add_positions({{5, 5, 5}, {6, 5, 5}, {5, 6, 5}});
  builder.add_mesh({GltfBuilder::primitive(first, builder.add_indices<uint8_t>({0, 1, 2})),
                    GltfBuilder::primitive(second),
                    GltfBuilder::primitive(first, builder.add_indices<uint8_t>({2, 1, 3}))});
  const SourceMesh mesh = read_one(builder);
  EXPECT_EQ(mesh.positions.size(), 7u);
  EXPECT_EQ(mesh.triangles, (Triangles{{0, 1, 2}, {4, 5, 6}, {2, 1, 3}}));
}

TEST_F(GltfIngest, ContainersAgree) {
  const GltfBuilder builder = square_file();
  GltfBuilder external = builder;
  external.document["buffers"][0]["uri"] = "sub%20folder/the%20data.bin";
  std::filesystem::create_directories(folder_ / "sub folder");
  write("sub folder/the data.bin", std::string(builder.data().begin(), builder.data().end()) + "and more");
  GltfBuilder plain = builder;
  std::string escaped = "data:,";
  for (const uint8_t byte : builder.data()) {
    char text[4];
    std::snprintf(text, sizeof text, "%%%02x", byte);
    escaped += text;
  }
  plain.document["buffers"][0]["uri"] = escaped;
  for (const std::string& content : {builder.embedded(), builder.embedded("model/x-whatever"), builder.glb(),
                                     external.document.dump(), plain.document.dump()}) {
    const Ingested ingested = read(content);
    ASSERT_EQ(ingested.meshes.size(), 1u);
    EXPECT_EQ(ingested.meshes[0].positions, square);
    EXPECT_EQ(ingested.meshes[0].triangles, square_triangles);
  }
}

TEST_F(GltfIngest, StripsAndFansKeepTheWinding) {
  for (const bool indexed : {false, true}) {
    GltfBuilder builder;
    const size_t positions = builder.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0}});
    std::optional<size_t> indices;
    if (indexed) indices = builder.add_indices<uint32_t>({4, 3, 2, 1, 0});
    builder.add_mesh({GltfBuilder::primitive(positions, indices, 5)});
    builder.add_mesh({GltfBuilder::primitive(positions, indices, 6)});
    const Ingested ingested = read(builder.embedded());
    ASSERT_EQ(ingested.meshes.size(), 2u);
    const Triangles strip = {{0, 1, 2}, {1, 3, 2}, {2, 3, 4}};
    const Triangles fan = {{1, 2, 0}, {2, 3, 0}, {3, 4, 0}};
    const Triangles reversed_strip = {{4, 3, 2}, {3, 1, 2}, {2, 1, 0}};
    const Triangles reversed_fan = {{3, 2, 4}, {2, 1, 4}, {1, 0, 4}};
    EXPECT_EQ(ingested.meshes[0].triangles, indexed ? reversed_strip : strip);
    EXPECT_EQ(ingested.meshes[1].triangles, indexed ? reversed_fan : fan);
  }
}

TEST_F(GltfIngest, VerticesThatFormNoTriangleAreNoted) {
  GltfBuilder builder;
  builder.add_mesh({GltfBuilder::primitive(builder.add_positions(square))});
  const Ingested ingested = read(builder.embedded());
  ASSERT_EQ(ingested.meshes.size(), 1u);
  EXPECT_EQ(ingested.meshes[0].triangles, (Triangles{{0, 1, 2}}));
  ASSERT_EQ(ingested.notes.size(), 1u);
  EXPECT_EQ(ingested.notes[0], "mesh 0, primitive 0: the last 1 of its vertices form no triangle");
}

TEST_F(GltfIngest, EveryIndexTypeIsRead) {
  GltfBuilder builder;
  const size_t positions = builder.add_positions(square);
  builder.add_mesh({GltfBuilder::primitive(positions, builder.add_indices<uint8_t>({0, 1, 2, 2, 1, 3}))});
  builder.add_mesh({GltfBuilder::primitive(positions, builder.add_indices<uint16_t>({0, 1, 2, 2, 1, 3}))});
  builder.add_mesh({GltfBuilder::primitive(positions, builder.add_indices<uint32_t>({0, 1, 2, 2, 1, 3}))});
  for (const SourceMesh& mesh : read(builder.embedded()).meshes) EXPECT_EQ(mesh.triangles, square_triangles);
}

TEST_F(GltfIngest, InterleavedPositionsAreReadByTheirStride) {
  GltfBuilder builder;
  std::vector<float> interleaved;
  for (const Position& p : square) interleaved.insert(interleaved.end(), {9, p[0], p[1], p[2], 9, 9});
  const size_t view = builder.add_view(bytes_of(interleaved), 24);
  const size_t positions = builder.add_accessor(view, float_type, "VEC3", 4);
  builder.document["accessors"][positions]["byteOffset"] = 4;
  builder.add_mesh({GltfBuilder::primitive(positions, builder.add_indices<uint8_t>({0, 1, 2, 2, 1, 3}))});
  EXPECT_EQ(read_one(builder).positions, square);
}

TEST_F(GltfIngest, SparseAccessorsReplaceViewsAndZeros) {
  GltfBuilder builder;
  const auto sparse = [&](size_t places, size_t values, size_t count) {
    return json{{"count", count},
                {"indices", {{"bufferView", places}, {"componentType", uint8_type}}},
                {"values", {{"bufferView", values}}}};
  };
  const size_t places = builder.add_view(bytes_of<uint8_t>({1, 3}));
  const size_t values = builder.add_view(bytes_of<Position>({{7, 8, 9}, {4, 5, 6}}));
  const size_t over_view = builder.add_positions(square);
  builder.document["accessors"][over_view]["sparse"] = sparse(places, values, 2);
  const size_t over_zeros = builder.add_accessor(std::nullopt, float_type, "VEC3", 4);
  builder.document["accessors"][over_zeros]["sparse"] = sparse(places, values, 2);
  const size_t indices = builder.add_indices<uint16_t>({0, 0, 2});
  const size_t index_values = builder.add_view(bytes_of<uint16_t>({3}));
  builder.document["accessors"][indices]["sparse"] = sparse(places, index_values, 1);
  builder.add_mesh({GltfBuilder::primitive(over_view, indices)});
  builder.add_mesh({GltfBuilder::primitive(over_zeros, indices)});
  const Ingested ingested = read(builder.embedded());
  ASSERT_EQ(ingested.meshes.size(), 2u);
  EXPECT_EQ(ingested.meshes[0].positions, (std::vector<Position>{{0, 0, 0}, {7, 8, 9}, {0, 1, 0}, {4, 5, 6}}));
  EXPECT_EQ(ingested.meshes[1].positions, (std::vector<Position>{{0, 0, 0}, {7, 8, 9}, {0, 0, 0}, {4, 5, 6}}));
  EXPECT_EQ(ingested.meshes[0].triangles, (Triangles{{0, 3, 2}}));
}

// Not in a template: there Clang 14 forgets to destroy what an initializer list holds.
void use_extension(GltfBuilder& builder, const char* name) { builder.document["extensionsUsed"] = {name}; }

template <class T>
void add_quantized_mesh(GltfBuilder& builder, int component, bool normalized) {
  const T low = std::numeric_limits<T>::min(), high = std::numeric_limits<T>::max();
  std::vector<T> padded;
  for (int vertex = 0; vertex < 3; ++vertex) padded.insert(padded.end(), {low, high, T(1), T(0)});
  const size_t view = builder.add_view(bytes_of(padded), 4 * sizeof(T));
  const size_t accessor = builder.add_accessor(view, component, "VEC3", 3);
  builder.document["accessors"][accessor]["normalized"] = normalized;
  use_extension(builder, "KHR_mesh_quantization");
  builder.add_mesh({GltfBuilder::primitive(accessor)});
}

TEST_F(GltfIngest, QuantizedPositionsFollowTheSpecification) {
  GltfBuilder builder;
  for (const bool normalized : {false, true}) {
    add_quantized_mesh<int8_t>(builder, int8_type, normalized);
    add_quantized_mesh<uint8_t>(builder, uint8_type, normalized);
    add_quantized_mesh<int16_t>(builder, int16_type, normalized);
    add_quantized_mesh<uint16_t>(builder, uint16_type, normalized);
  }
  const std::vector<Position> expected = {{-128, 127, 1},       {0, 255, 1},        {-32768, 32767, 1},
                                          {0, 65535, 1},        {-1, 1, 1 / 127.f}, {0, 1, 1 / 255.f},
                                          {-1, 1, 1 / 32767.f}, {0, 1, 1 / 65535.f}};
  const Ingested ingested = read(builder.embedded());
  ASSERT_EQ(ingested.meshes.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(ingested.meshes[i].positions[2], expected[i]) << i;
}

TEST_F(GltfIngest, WhatOnlyTexturesUseMayBeMissing) {
  GltfBuilder builder = square_file();
  builder.document["images"] = {{{"uri", "nowhere.png"}}, {{"bufferView", 99}, {"mimeType", "image/png"}}};
  builder.document["textures"] = {{{"source", 7}}};
  builder.document["materials"] = {{{"normalTexture", {{"index", 5}}}}};
  builder.document["buffers"].push_back({{"byteLength", 100}, {"uri", "nowhere.bin"}});
  builder.document["meshes"][0]["primitives"][0]["material"] = 0;
  EXPECT_EQ(read_one(builder).triangles.size(), 2u);
}

TEST_F(GltfIngest, PointsAndLinesArePassedOver) {
  GltfBuilder builder = square_file();
  for (const int mode : {0, 1, 2, 3}) builder.add_mesh({GltfBuilder::primitive(0, std::nullopt, mode)});
  const Ingested ingested = read(builder.embedded());
  EXPECT_EQ(ingested.meshes.size(), 1u);
  ASSERT_EQ(ingested.notes.size(), 8u);
  EXPECT_EQ(ingested.notes[0], "mesh 1, primitive 0 passed over: points");
  EXPECT_EQ(ingested.notes[1], "mesh 1 omitted: no triangle is left of it");
  EXPECT_EQ(ingested.notes[2], "mesh 2, primitive 0 passed over: lines");
}

TEST_F(GltfIngest, PartsThatAreNotOpaqueAreLeftOut) {
  const json transmission = {{"KHR_materials_transmission", {{"transmissionFactor", 0.5}}}};
  const json textured = {{"KHR_materials_transmission", {{"transmissionTexture", {{"index", 0}}}}}};
  const json none = {{"KHR_materials_transmission", {{"transmissionFactor", 0}}},
                     {"KHR_materials_volume", json::object()}};
  const std::vector<std::pair<json, bool>> cases = {
      {{{"alphaMode", "MASK"}}, false},    {{{"alphaMode", "BLEND"}}, false}, {{{"extensions", transmission}}, false},
      {{{"extensions", textured}}, false}, {{{"extensions", none}}, true},    {{{"alphaMode", "OPAQUE"}}, true}};
  for (const auto& [material, opaque] : cases) {
    GltfBuilder builder = square_file();
    json part = builder.document["meshes"][0]["primitives"][0];
    part["material"] = builder.append("materials", material);
    builder.document["meshes"][0]["primitives"].push_back(part);
    const Ingested ingested = read(builder.embedded());
    ASSERT_EQ(ingested.meshes.size(), 1u);
    EXPECT_EQ(ingested.meshes[0].triangles.size(), opaque ? 4u : 2u) << material;
    ASSERT_EQ(ingested.notes.size(), opaque ? 0u : 1u);
    if (!opaque) {
      EXPECT_EQ(ingested.notes[0].rfind("mesh 0 \"Square\", primitive 1 left out: ", 0), 0u);
    }
    EXPECT_EQ(read_one(builder, {.treat_all_as_opaque = true}).triangles.size(), 4u);
  }
}

TEST_F(GltfIngest, AVariantThatIsNotOpaqueCounts) {
  GltfBuilder builder = square_file();
  builder.add_mesh({builder.document["meshes"][0]["primitives"][0]});
  const size_t glass = builder.append("materials", {{"alphaMode", "BLEND"}});
  builder.document["meshes"][1]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] = {
      {{"material", glass}, {"variants", {0}}}};
  EXPECT_EQ(read(builder.embedded()).meshes.size(), 1u);
}

TEST_F(GltfIngest, PartsThatDeformAreLeftOut) {
  GltfBuilder builder = square_file();
  json part = builder.document["meshes"][0]["primitives"][0];
  part["attributes"]["JOINTS_0"] = 0;
  part["attributes"]["WEIGHTS_0"] = 0;
  builder.add_mesh({part}, "skinned");
  builder.add_mesh({part}, "joints, but no skin");
  part["targets"] = {{{"POSITION", 0}}};
  builder.add_mesh({part}, "morphed");
  builder.document["nodes"] = {{{"mesh", 1}}, {{"mesh", 1}, {"skin", 0}}, {{"mesh", 2}}};
  const Ingested ingested = read(builder.embedded());
  ASSERT_EQ(ingested.meshes.size(), 2u);
  EXPECT_EQ(ingested.meshes[1].source_index, 2u);
  ASSERT_EQ(ingested.notes.size(), 4u);
  EXPECT_EQ(ingested.notes[0], "mesh 1 \"skinned\", primitive 0 left out: a node deforms it with a skin");
  EXPECT_EQ(ingested.notes[2], "mesh 3 \"morphed\", primitive 0 left out: it has morph targets");
  EXPECT_EQ(read(builder.embedded(), {.treat_all_as_opaque = true}).meshes.size(), 4u);
}

TEST_F(GltfIngest, CyclicAndBrokenNodesDoNoHarm) {
  GltfBuilder builder = square_file();
  builder.document["nodes"] = {{{"children", {1}}, {"mesh", 0}}, {{"children", {0, 1, 99}}, {"mesh", 99}}, 7};
  builder.document["scenes"] = {{{"nodes", {0, 44}}}};
  EXPECT_EQ(read_one(builder).triangles.size(), 2u);
}

TEST_F(GltfIngest, HarmlessRequiredExtensionsAreAccepted) {
  GltfBuilder builder = square_file();
  builder.document["extensionsRequired"] = {"KHR_materials_unlit", "KHR_texture_basisu",      "EXT_texture_webp",
                                            "CESIUM_RTC",          "EXT_mesh_gpu_instancing", "KHR_lights_punctual",
                                            "EXT_mesh_features",   "EXT_structural_metadata", "KHR_texture_transform"};
  EXPECT_EQ(read_one(builder).triangles.size(), 2u);
}

}  // namespace
}  // namespace vcd::test
