// Files as they come from the field: what must not change a mesh, what is worth a note, and what is told by its name.
#include <chrono>

#include <vcd/baker/prepare.h>

#include "draco_encode.h"
#include "gltf_builder.h"
#include "ingest/polygon.h"
#include "mesh_files.h"

namespace vcd::test {
namespace {

using namespace baker;

class Field : public MeshFiles {
 protected:
  Ingested read_gltf(const GltfBuilder& builder) { return read("a.glb", builder.glb()); }
};

TEST_F(Field, ABackslashThatEndsARemarkOrANameContinuesNothing) {
  const std::string plain = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
  const auto expected = soup_of(read("a.obj", plain).meshes[0]);
  for (const char* ending : {"# C:\\", "o C:\\a\\", "g C:\\", "usemtl C:\\", "mtllib C:\\", "usemap C:\\",
                             "maplib C:\\", "shadow_obj C:\\", "nobody_knows C:\\"}) {
    std::string text = plain;
    text.insert(text.find("v 1 1"), std::string(ending) + "\n");
    EXPECT_EQ(soup_of(read("a.obj", text).meshes[0]), expected) << ending;
  }
  std::string text = plain;
  text.insert(text.find("\nv 1 1"), " # as in C:\\");
  EXPECT_EQ(soup_of(read("a.obj", text).meshes[0]), expected);
  EXPECT_EQ(soup_of(read("a.obj", "v 0 0 \\\n0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 \\\n3 # \\\nf 1 3 4\n").meshes[0]),
            expected);
}

TEST_F(Field, MeshesThatShareAnAccessorCostWhatTheyUse) {
  constexpr size_t kMeshes = 3000;
  GltfBuilder builder;
  std::vector<Position> positions;
  for (size_t i = 0; i < kMeshes; ++i)
    for (int corner = 0; corner < 8; ++corner)
      positions.push_back({float(i) + corner % 2, float(corner / 2), float(i % 7)});
  const size_t accessor = builder.add_positions(positions);
  for (uint32_t i = 0; i < kMeshes; ++i)
    builder.add_mesh({GltfBuilder::primitive(accessor, builder.add_indices<uint32_t>({8 * i, 8 * i + 1, 8 * i + 2}))});
  const Ingested ingested = *ingest(write("a.glb", builder.glb()));
  ASSERT_EQ(ingested.meshes.size(), kMeshes);
  size_t kept = 0;
  for (const SourceMesh& mesh : ingested.meshes) kept += mesh.positions.size();
  EXPECT_EQ(kept, 3 * kMeshes);
  EXPECT_EQ(soup_of(ingested.meshes[5])[0], (std::array<Position, 3>{positions[40], positions[41], positions[42]}));
}

// A box of 8 × 8 × 6 units, `far` units away, in decimals.
std::string house(double far) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    char line[120];
    std::snprintf(line, sizeof line, "v %.3f %.3f %.3f\n", far / 10 + (i & 1) * 8.15, far + (i & 2) * 4.13,
                  (i & 4) * 1.6);
    text += line;
  }
  return text +
         "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n";
}

TEST_F(Field, CoordinatesThatFloatsCannotHoldAreNotedOrRefused) {
  EXPECT_TRUE(read("a.obj", house(0)).notes.empty());
  EXPECT_TRUE(read("a.obj", house(500)).notes.empty());
  EXPECT_TRUE(any_note_has(read("a.obj", house(20000)), "32-bit floats move them by up to"));
  expect_error(
      "a.obj", house(5654321.12), ErrorCode::unsupported,
      {"32-bit floats move them by up to 0.", "at an extent of 8.", "--shift 565436,5654325,3", "--allow-rounding"});
  EXPECT_TRUE(any_note_has(*ingest(write("a.obj", house(5654321.12)), {.coarse = true}), "32-bit floats move them"));
}

TEST_F(Field, AShiftIsSubtractedBeforeCoordinatesAreRounded) {
  const auto path = write("a.obj", house(5654321.12));
  const auto near = ingest(path, {.shift = {565432.112, 5654321.12, 0}});
  ASSERT_TRUE(near.ok()) << near.error().message;
  EXPECT_TRUE(near->notes.empty());
  EXPECT_EQ(near->meshes[0].shift, (std::array<double, 3>{565432.112, 5654321.12, 0}));
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(near->meshes[0].positions[i][0], (i & 1) * 8.15, 1e-3);
    EXPECT_NEAR(near->meshes[0].positions[i][1], (i & 2) * 4.13, 1e-3);
  }
  EXPECT_EQ(ingest_isolated(path, {.shift = {565432.112, 5654321.12, 0}})->meshes[0].shift, near->meshes[0].shift);
}

TEST_F(Field, DoublesOfPlyAndWordsOfStlAndOffAreMeasuredToo) {
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
      "property double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (const double value : {5e6 + 0.1, 0.0, 0.0, 5e6 + 1.2, 0.0, 0.0, 5e6 + 0.1, 1.0, 0.0}) ply += packed(value);
  ply += packed(uint8_t{3}) + packed(0) + packed(1) + packed(2);
  expect_error("a.ply", ply, ErrorCode::unsupported, {"32-bit floats"});
  expect_error("a.off", "OFF\n3 1 0\n5000000.1 0 0\n5000001.2 0 0\n5000000.1 1 0\n3 0 1 2\n", ErrorCode::unsupported,
               {"32-bit floats"});
  expect_error("a.stl",
               "solid a\nfacet normal 0 0 1\nouter loop\nvertex 5000000.1 0 0\nvertex 5000001.2 0 0\n"
               "vertex 5000000.1 1 0\nendloop\nendfacet\nendsolid a\n",
               ErrorCode::unsupported, {"32-bit floats"});
}

TEST_F(Field, VerticesThatNoFaceUsesAreNotMeasured) {
  EXPECT_TRUE(read("a.obj", "v 5000000.1 5000000.1 0\nv 0 0 0\nv 1.1 0 0\nv 0 1.1 0\nf 2 3 4\n").notes.empty());
}

TEST_F(Field, DecimalsMidwayBetweenFloatsAreRoundedOnce) {
  // 1 + 2^-24, the middle between 1 and the float above it, and decimals so near to it that their doubles are it.
  const Ingested ingested =
      read("a.obj",
           "v 1.000000059604644775390625 1.00000005960464477539062500001 1.0000000596046447753906249\n"
           "v 0 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(ingested.meshes[0].positions[0], (Position{1.0f, 1.00000012f, 1.0f}));
}

TEST_F(Field, PolygonsThatAreNotPlaneAreCounted) {
  const std::string bent =
      "v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nf 1 2 3 4\nv 2 0 0\nv 2 1 0\nf 2 5 6\nv 3 0 0.00001\nv 3 1 0\nf 5 7 8 6\n";
  const Ingested ingested = read("a.obj", bent);
  EXPECT_TRUE(any_note_has(ingested, "1 face (the first is number 0, counted from 0) of 3 not plane"))
      << ingested.notes.size();
  // A convex polygon is a fan from its first corner: the rule in spec/conventions.md.
  EXPECT_EQ(ingested.meshes[0].triangles[0], (TriangleIndices{0, 1, 2}));
  EXPECT_EQ(ingested.meshes[0].triangles[1], (TriangleIndices{0, 2, 3}));
}

TEST_F(Field, SurfacesThatLetLightThroughByAnyExtensionAreLeftOut) {
  const std::vector<std::pair<json, bool>> materials = {
      {{{"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.5}}}}}}, true},
      {{{"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0}}}}}}, false},
      {{{"extensions", {{"ADOBE_materials_thin_transparency", {{"transmissionFactor", 1.0}, {"ior", 1.4}}}}}}, true},
      {{{"extensions", {{"ADOBE_materials_thin_transparency", {{"ior", 1.4}}}}}}, false},
      {{{"extensions", {{"KHR_materials_diffuse_transmission", {{"diffuseTransmissionFactor", 0.2}}}}}}, true},
      {{{"extensions", {{"KHR_materials_clearcoat", {{"clearcoatFactor", 1}}}}}}, false}};
  for (const auto& [material, left_out] : materials) {
    GltfBuilder builder = square_file();
    json glass = builder.document["meshes"][0]["primitives"][0];
    glass["material"] = 0;
    builder.document["meshes"][0]["primitives"].push_back(glass);
    builder.document["materials"] = json::array({material});
    const Ingested ingested = read_gltf(builder);
    EXPECT_EQ(ingested.meshes[0].triangles.size(), left_out ? 2u : 4u) << material;
    EXPECT_EQ(ingested.meshes[0].left_out, (LeftOut{left_out ? 1u : 0u, 0})) << material;
    EXPECT_EQ(ingest_isolated(folder_ / "a.glb")->meshes[0].left_out, ingested.meshes[0].left_out);
    EXPECT_EQ(prepare(SourceMesh(ingested.meshes[0]))->left_out, ingested.meshes[0].left_out);
  }
}

TEST_F(Field, GlassThatAnAnimationTurnsOnIsLeftOut) {
  for (const char* target :
       {"/materials/0/extensions/KHR_materials_transmission/transmissionFactor",
        "/materials/1/extensions/KHR_materials_transmission/transmissionFactor", "/materials/0/emissiveFactor"}) {
    GltfBuilder builder = square_file();
    json glass = builder.document["meshes"][0]["primitives"][0];
    glass["material"] = 0;
    builder.document["meshes"][0]["primitives"].push_back(glass);
    builder.document["materials"] = {{{"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0}}}}}}};
    builder.document["extensionsUsed"] = {"KHR_animation_pointer", "KHR_materials_transmission"};
    builder.document["animations"] = {
        {{"channels",
          {{{"sampler", 0},
            {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", target}}}}}}}}}}}};
    EXPECT_EQ(read_gltf(builder).meshes[0].left_out.not_opaque,
              std::string(target).find("/0/ext") != std::string::npos ? 1u : 0u);
  }
}

TEST_F(Field, PartsWithoutAVertexCostANote) {
  GltfBuilder builder = square_file();
  const size_t none = builder.add_accessor(std::nullopt, float_type, "VEC3", 0);
  builder.add_mesh({GltfBuilder::primitive(none)}, "empty");
  builder.add_mesh({GltfBuilder::primitive(0, builder.add_accessor(std::nullopt, uint16_type, "SCALAR", 0))},
                   "no index");
  builder.add_mesh({}, "no primitive");
  const Ingested ingested = read_gltf(builder);
  for (const char* name : {"\"empty\" omitted", "\"no index\" omitted", "\"no primitive\" omitted"})
    EXPECT_TRUE(any_note_has(ingested, name)) << name;
}

TEST_F(Field, StridesOfNothingAndOfWholeElementsAreTaken) {
  for (const size_t stride : {0, 2, 4}) {
    GltfBuilder builder = square_file();
    if (stride == 4) builder.document["accessors"][1]["count"] = 3;
    builder.document["bufferViews"][1]["byteStride"] = stride;
    const Ingested ingested = read_gltf(builder);
    EXPECT_EQ(ingested.meshes[0].triangles[0], stride == 4 ? (TriangleIndices{0, 2, 1}) : (TriangleIndices{0, 1, 2}));
  }
  GltfBuilder builder = square_file();
  builder.document["bufferViews"][0]["byteStride"] = 0;
  builder.document["nodes"] = {{{"mesh", 0}, {"skin", nullptr}}};
  builder.document["meshes"][0]["weights"] = nullptr;
  builder.document["meshes"][0]["primitives"][0]["targets"] = nullptr;
  EXPECT_EQ(read_gltf(builder).meshes[0].positions, square);
}

TEST_F(Field, WhatIsNoMeshIsToldByItsName) {
  const std::vector<std::pair<std::string, std::string>> files = {
      {"version https://git-lfs.github.com/spec/v1\noid sha256:0f\nsize 18\n", "is a Git LFS pointer"},
      {"/annex/objects/SHA256E-s18--0f.obj\n", "is a git-annex pointer"},
      {"<!DOCTYPE html>\n<html>", "is a web page (HTML)"},
      {"\xEF\xBB\xBF\r\n <HTML lang=en>", "is a web page (HTML)"},
      {"<?xml version='1.0'?><Error>", "is XML"},
      {std::string("\x1F\x8B\x08\0", 4), "is compressed with gzip"},
      {"PK\x03\x04", "is a zip archive"}};
  for (const auto& [bytes, what] : files)
    for (const std::string& extension : mesh_extensions()) expect_invalid("a." + extension, bytes, {what});
  // The header of a binary STL file is anyone's.
  std::string stl = files[0].first;
  stl.resize(80);
  stl += packed(uint32_t{1});
  for (const float value : {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}) stl += packed(value);
  EXPECT_EQ(read("a.stl", stl + std::string(2, '\0')).meshes[0].triangles.size(), 1u);
  // A buffer may be a pointer too.
  GltfBuilder builder = square_file();
  builder.document["buffers"][0]["uri"] = "a.bin";
  write("a.bin", files[0].first);
  builder.document["buffers"][0]["byteLength"] = 1000000;
  expect_invalid("a.gltf", builder.document.dump(), {"the file \"a.bin\" is a Git LFS pointer"});
}

TEST_F(Field, MalformedJsonIsToldWithItsPlaceAndReason) {
  expect_invalid("a.gltf", "{\"asset\": {\"version\": \"2.0\"},\n\"meshes\": [1,]}",
                 {"the JSON is malformed: line 2, column 14: ", "unexpected ']'"});
  expect_invalid("a.gltf", "{\"asset\":\n\n  NaN}", {"line 3, column 3: ", "invalid literal"});
  expect_invalid("a.gltf", "{\"a\": \"caf\xE9\"}", {"line 1, column 12: ", "ill-formed UTF-8"});
  expect_invalid("a.gltf", "{\"a\": 1e999}", {"the JSON is malformed: ", "1e999"});
  expect_invalid("a.gltf", "{\"a\"", {"line 1, column 5: ", "unexpected end of input"});
  expect_error("a.gltf", std::string("\xFF\xFE{\0", 4), ErrorCode::unsupported, {"UTF-16"});
}

TEST_F(Field, HeadersOfPlyMayEndTheirLinesInAnyMixture) {
  const std::vector<std::string> lines = {"ply",
                                          "format binary_little_endian 1.0",
                                          "element vertex 3",
                                          "property float x",
                                          "property float y",
                                          "property float z",
                                          "element face 1",
                                          "property list uchar int vertex_indices",
                                          "end_header"};
  std::string body;
  for (const float value : {0, 0, 0, 1, 0, 0, 0, 1, 0}) body += packed(value);
  body += packed(uint8_t{3}) + packed(0) + packed(1) + packed(2);
  const std::string ends[] = {"\n", "\r\n", "\r"};
  for (size_t first = 0; first < 3; ++first)
    for (size_t middle = 0; middle < 3; ++middle)
      for (size_t last = 0; last < 3; ++last) {
        if (middle == 2 && last == 1) continue;  // after bare CRs, a LF belongs to the data
        std::string text;
        for (size_t i = 0; i < lines.size(); ++i)
          text += lines[i] + ends[i == 0 ? first : i + 1 < lines.size() ? middle : last];
        EXPECT_EQ(read("a.ply", text + body).meshes[0].positions[1], (Position{1, 0, 0})) << first << middle << last;
      }
}

}  // namespace
}  // namespace vcd::test
