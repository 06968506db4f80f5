// What reaches tinygltf, it takes: the gate leaves out or mends the rest.
#include "ingest/gltf_gate.h"

#include <nlohmann/json.hpp>

#include "gltf_builder.h"
#include "ingest/gltf.h"

namespace vcd::test {
namespace {

using namespace baker;

// Has each property that the gate knows.
const json whole_document = json::parse(R"({
  "asset": {"version": "2.0", "minVersion": "2.0"},
  "extensionsUsed": ["KHR_mesh_quantization"], "extensionsRequired": ["KHR_mesh_quantization"],
  "buffers": [{"byteLength": 48, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"}],
  "bufferViews": [
    {"buffer": 0, "byteOffset": 0, "byteLength": 36, "byteStride": 12},
    {"buffer": 0, "byteLength": 12, "extensions": {"EXT_meshopt_compression": {
      "mode": "ATTRIBUTES", "filter": "NONE", "count": 3, "byteStride": 4, "buffer": 0, "byteOffset": 0, "byteLength": 12}}},
    {"buffer": 0, "byteLength": 3, "byteStride": 1}],
  "accessors": [
    {"componentType": 5126, "normalized": false, "count": 3, "type": "VEC3", "bufferView": 0, "byteOffset": 0,
     "sparse": {"count": 1, "indices": {"componentType": 5121, "bufferView": 0, "byteOffset": 0},
                "values": {"bufferView": 0, "byteOffset": 0}}},
    {"componentType": 5121, "count": 3, "type": "SCALAR", "bufferView": 2}],
  "materials": [{"alphaMode": "OPAQUE", "extensions": {
    "KHR_materials_transmission": {"transmissionFactor": 0, "transmissionTexture": {"index": 0}}}}],
  "meshes": [{"name": "m", "primitives": [
    {"mode": 4, "attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}], "material": 0, "indices": 1},
    {"attributes": {"POSITION": 0}, "extensions": {
      "KHR_draco_mesh_compression": {"bufferView": 1, "attributes": {"POSITION": 0}},
      "KHR_materials_variants": {"mappings": [{"material": 0}]}}}]}],
  "nodes": [
    {"name": "n", "children": [1], "mesh": 0, "skin": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]},
    {"translation": [0,0,0], "rotation": [0,0,0,1], "scale": [1,1,1],
     "extensions": {"EXT_mesh_gpu_instancing": {}, "KHR_lights_punctual": {"light": 0}},
     "extras": {"area_light": {"width": 1, "height": 1}}}],
  "scene": 0, "scenes": [{"nodes": [0], "extras": {"sky_light": true}}],
  "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "range": 1, "spot": {"outerConeAngle": 1}}]}},
  "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "pointer", "extensions": {
    "KHR_animation_pointer": {"pointer": "/materials/0/extensions/KHR_materials_transmission/transmissionFactor"}}}}]}]
})");

const json odd_values = json::parse(R"([null, true, "", "x", "SCALAR", "spot", [], [null], [[]], [{}], [0], ["x"], {},
  {"a": {}}, -1, 0, 1, 2, 1.5, 252, 254, 5126, 1e300, 2147483648, 4294967295, 4294967296, 9007199254740993,
  18446744073709551615])");

void collect(const json& value, const json::json_pointer& here, std::vector<json::json_pointer>& all) {
  if (!here.empty()) all.push_back(here);
  if (value.is_object())
    for (const auto& [key, child] : value.items()) collect(child, here / key, all);
  if (value.is_array())
    for (size_t i = 0; i < value.size(); ++i) collect(value[i], here / i, all);
}

class GltfGate : public ::testing::Test {
 protected:
  static void expect_taken(const json& document, const std::string& what) {
    const auto result = ingest_gltf("a.gltf", document.dump(), {.treat_all_as_opaque = true, .lights = true});
    if (result) return;
    EXPECT_EQ(result.error().message.find("tinygltf"), std::string::npos) << what << ": " << result.error().message;
    EXPECT_NE(result.error().code, ErrorCode::runtime) << what << ": " << result.error().message;
  }
};

TEST_F(GltfGate, WhateverAPropertyIsTinygltfTakesTheFile) {
  std::vector<json::json_pointer> places;
  collect(whole_document, json::json_pointer(), places);
  ASSERT_GT(places.size(), 120u);
  for (const json::json_pointer& place : places) {
    for (const json& value : odd_values) {
      json bent = whole_document;
      bent[place] = value;
      expect_taken(bent, place.to_string() + " = " + value.dump());
    }
    json without = whole_document;
    const json::json_pointer parent = place.parent_pointer();
    if (without[parent].is_object()) without[parent].erase(place.back());
    else without[parent].erase(std::stoul(place.back()));
    expect_taken(without, "without " + place.to_string());
  }
}

TEST_F(GltfGate, OnlyWhatIsReadPasses) {
  json more = whole_document;
  more["images"] = {{{"uri", "../secret.png"}}};
  more["accessors"][0]["min"] = {0, 0, 0};
  more["buffers"][0]["extras"] = {{"a", 1}};
  const GltfGated gated = gate_gltf(more);
  EXPECT_TRUE(gated.faults.empty()) << gated.faults.begin()->second;
  EXPECT_EQ(gated.json, gate_gltf(whole_document).json);
  EXPECT_EQ(json::parse(gated.json)["buffers"], json::parse(R"([{"byteLength": 1, "uri": "stub"}])"));
  EXPECT_EQ(gated.buffers[0].uri, whole_document["buffers"][0]["uri"]);
}

TEST_F(GltfGate, AFaultIsThatOfItsElement) {
  json bent = whole_document;
  bent["accessors"][1]["count"] = "3";
  bent["meshes"][0]["primitives"][1]["material"] = 7u;
  const std::map<std::string, std::string> wanted = {
      {"/accessors/1", "accessor 1: count is not a non-negative integer"},
      {"/meshes/0/primitives/1", "material 7 does not exist, the file has 1"}};
  EXPECT_EQ(gate_gltf(bent).faults, wanted);
}

}  // namespace
}  // namespace vcd::test
