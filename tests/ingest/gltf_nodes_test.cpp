// Where the nodes of a glTF file put its meshes, and what is wrong with nodes.
#include <vcd/baker/ingest.h>

#include <cmath>
#include <functional>

#include "gltf_builder.h"

namespace vcd::test {
namespace {

using namespace baker;

using Transform = std::array<double, 12>;
constexpr Transform identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

const double half = std::sqrt(0.5);

// (x, y, z) -> (-3 y + 1, 2 x + 2, 4 z + 3): scaled, then turned a quarter about z, then moved.
const json turned = {{"mesh", 0}, {"translation", {1, 2, 3}}, {"rotation", {0, 0, half, half}}, {"scale", {2, 3, 4}}};
constexpr Transform turned_transform = {0, -3, 0, 1, 2, 0, 0, 2, 0, 0, 4, 3};

class GltfNodes : public GltfTest {
 protected:
  // square_file() with these nodes, and no scene.
  static GltfBuilder with_nodes(const json& nodes) {
    GltfBuilder builder = square_file();
    builder.document["nodes"] = nodes;
    return builder;
  }
  Ingested read(const GltfBuilder& builder, IngestOptions options = {.placements = true}) {
    const Result<Ingested> result = ingest(write("file.gltf", builder.embedded()), options);
    if (result) return *result;
    ADD_FAILURE() << result.error().message;
    return {};
  }
  void expect_transforms(const json& nodes, const std::vector<Transform>& expected) {
    const Ingested ingested = read(with_nodes(nodes));
    ASSERT_EQ(ingested.placements.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i) {
      for (size_t k = 0; k < 12; ++k)
        EXPECT_NEAR(ingested.placements[i].transform[k], expected[i][k], 1e-6) << "placement " << i << ", " << k;
    }
  }
  void expect_left_out(const json& node, const std::string& note) {
    const Ingested ingested = read(with_nodes({{{"mesh", 0}}, node}));
    EXPECT_EQ(ingested.placements, std::vector<Placement>{{}});
    EXPECT_EQ(ingested.notes, std::vector<std::string>{note});
  }
};

TEST_F(GltfNodes, TranslationRotationAndScaleAgreeWithAMatrix) {
  expect_transforms({turned, {{"mesh", 0}, {"matrix", {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 1, 2, 3, 1}}}},
                    {turned_transform, turned_transform});
}

TEST_F(GltfNodes, RotationsTurnCounterClockwiseAboutTheirAxis) {
  expect_transforms({{{"mesh", 0}, {"rotation", {half, 0, 0, half}}},
                     {{"mesh", 0}, {"rotation", {0, half, 0, half}}},
                     {{"mesh", 0}, {"rotation", {0.5, 0.5, 0.5, 0.5}}},
                     {{"mesh", 0}, {"rotation", {0, 0, 2, 2}}}},  // its length has no say
                    {{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0},
                     {0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0},
                     {0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0},
                     {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}});
}

TEST_F(GltfNodes, EachPartHasItsDefault) {
  expect_transforms({{{"mesh", 0}}, {{"mesh", 0}, {"translation", {7, 8, 9}}}, {{"mesh", 0}, {"scale", {2, 3, 4}}}},
                    {identity, {1, 0, 0, 7, 0, 1, 0, 8, 0, 0, 1, 9}, {2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0}});
}

TEST_F(GltfNodes, AMirroredScaleIsKept) {
  expect_transforms({{{"mesh", 0}, {"scale", {-1, 1, 1}}}}, {{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}});
}

TEST_F(GltfNodes, ChildrenStandInTheirParentsFrame) {
  json parent = turned;
  parent.erase("mesh");
  parent["children"] = {0};
  expect_transforms({{{"mesh", 0}, {"translation", {1, 0, 0}}, {"scale", {1, 2, 1}}}, parent},
                    {{0, -6, 0, 1, 2, 0, 0, 4, 0, 0, 4, 3}});
}

TEST_F(GltfNodes, DeepNestingNeitherOverflowsNorAddsUpRounding) {
  json nodes;
  constexpr uint32_t depth = 100'000;
  for (uint32_t i = 0; i < depth; ++i) nodes.push_back({{"translation", {0.1, 0, 0}}, {"children", {i + 1}}});
  nodes[depth - 1].erase("children");
  nodes[depth - 1]["mesh"] = 0;
  const Ingested ingested = read(with_nodes(nodes));
  ASSERT_EQ(ingested.placements.size(), 1u);
  EXPECT_FLOAT_EQ(ingested.placements[0].transform[3], 10'000.0f);
}

TEST_F(GltfNodes, OneMeshStandsUnderManyNodesInTheirOrder) {
  GltfBuilder builder = square_file();
  builder.add_mesh({builder.document["meshes"][0]["primitives"][0]});
  builder.document["nodes"] = {{{"mesh", 1}, {"children", {3}}}, {{"mesh", 0}}, {{"children", {1}}}, {{"mesh", 1}}};
  const Ingested ingested = read(builder);
  EXPECT_EQ(ingested.meshes.size(), 2u);
  EXPECT_EQ(ingested.placements, (std::vector<Placement>{{1}, {0}, {1}}));
  EXPECT_TRUE(ingested.notes.empty());
}

TEST_F(GltfNodes, MeshesAreCountedAsIngestReturnsThem) {
  GltfBuilder builder = square_file();
  const json primitive = builder.document["meshes"][0]["primitives"][0];
  builder.document["meshes"][0]["primitives"][0]["mode"] = 0;  // points: left out
  builder.add_mesh({primitive});
  builder.document["nodes"] = {{{"mesh", 0}}, {{"mesh", 1}}};
  const Ingested ingested = read(builder);
  ASSERT_EQ(ingested.meshes.size(), 1u);
  EXPECT_EQ(ingested.placements, std::vector<Placement>{{}});
}

TEST_F(GltfNodes, TheDefaultSceneIsDrawn) {
  GltfBuilder builder = with_nodes({{{"mesh", 0}, {"translation", {1, 0, 0}}},
                                    {{"children", {2}}},
                                    {{"mesh", 0}, {"translation", {2, 0, 0}}},
                                    {{"mesh", 0}, {"translation", {3, 0, 0}}}});
  const auto shifts = [&] {
    std::vector<double> x;
    for (const Placement& placement : read(builder).placements) x.push_back(placement.transform[3]);
    return x;
  };
  EXPECT_EQ(shifts(), (std::vector<double>{1, 2, 3}));  // no scenes: all
  builder.document["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1, 3}}}};
  EXPECT_EQ(shifts(), (std::vector<double>{1}));
  builder.document["scene"] = 1;
  EXPECT_EQ(shifts(), (std::vector<double>{2, 3}));
}

TEST_F(GltfNodes, NothingPlacedIsNoted) {
  for (const json& nodes : {json::array(), json::array({{{"camera", 0}}})}) {
    const Ingested ingested = read(with_nodes(nodes));
    EXPECT_EQ(ingested.meshes.size(), 1u);
    EXPECT_TRUE(ingested.placements.empty());
    EXPECT_EQ(ingested.notes, std::vector<std::string>{"no node of the default scene places a mesh"});
  }
}

TEST_F(GltfNodes, ATransformThatCannotBeUndoneIsLeftOut) {
  expect_left_out({{"mesh", 0}, {"name", "x"}, {"scale", {1, 0, 1}}}, "node 1 \"x\" left out: its scale is zero");
  expect_left_out({{"mesh", 0}, {"scale", {1e-20, 1e-20, 1}}}, "node 1 left out: its scale is zero");
  for (const json& scale : {json{1e200, 1, 1}, json{1e20, 1e20, 1e20}}) {
    expect_left_out({{"mesh", 0}, {"scale", scale}},
                    "node 1 left out: its transform is not finite in single precision");
  }
}

TEST_F(GltfNodes, AZeroScaleBetweenRotationsIsZero) {
  const json askew = {0.1, 0.2, 0.3, 0.9};
  const Ingested ingested = read(
      with_nodes({{{"rotation", askew}, {"scale", {1, 1, 0}}, {"children", {1}}}, {{"mesh", 0}, {"rotation", askew}}}));
  EXPECT_TRUE(ingested.placements.empty());
  ASSERT_EQ(ingested.notes.size(), 2u);
  EXPECT_EQ(ingested.notes[0], "node 1 left out: its scale is zero");
  // Flat, but not zero.
  EXPECT_EQ(read(with_nodes({{{"mesh", 0}, {"rotation", askew}, {"scale", {1, 1, 1e-5}}}})).placements.size(), 1u);
}

TEST_F(GltfNodes, GpuInstancesAreLeftOut) {
  expect_left_out({{"mesh", 0}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", json::object()}}}}}},
                  "node 1 left out: its instances (EXT_mesh_gpu_instancing) are not read");
}

struct NodeDefect {
  const char* name;
  std::function<void(json&)> bend;  // of a document with the nodes 0 "root" -> 1 and 2, all in scene 0
  const char* reason;
};

const std::vector<NodeDefect> node_defects = {
    {"no child", [](json& d) { d["nodes"][0]["children"] = {3}; },
     "node 0 \"root\", children: node 3 does not exist, the file has 3"},
    {"far child", [](json& d) { d["nodes"][0]["children"] = {uint64_t{1} << 32}; }, "node 4294967296 does not exist"},
    {"negative child", [](json& d) { d["nodes"][0]["children"] = {-1}; },
     "node 0 \"root\", children: an entry is not a non-negative"},
    {"children as text", [](json& d) { d["nodes"][0]["children"] = "all"; }, "children is not an array"},
    {"no root", [](json& d) { d["scenes"][0]["nodes"] = {3}; }, "scene 0, nodes: node 3 does not exist"},
    {"root as text", [](json& d) { d["scenes"][0]["nodes"] = {"0"}; },
     "scene 0, nodes: an entry is not a non-negative"},
    {"no scene", [](json& d) { d["scene"] = 1; }, "scene 1 does not exist"},
    {"scene as text", [](json& d) { d["scene"] = "0"; }, "scene is not a non-negative integer"},
    {"no mesh", [](json& d) { d["nodes"][1]["mesh"] = 1; }, "node 1: mesh 1 does not exist, the file has 1"},
    {"mesh as text", [](json& d) { d["nodes"][1]["mesh"] = "0"; }, "node 1: mesh is not"},
    {"node as text", [](json& d) { d["nodes"][1] = "0"; }, "node 1: is not a JSON object"},
    {"short matrix",
     [](json& d) {
       d["nodes"][1]["matrix"] = {1, 2, 3};
     },
     "node 1: matrix has 3 numbers instead of 16"},
    {"long scale",
     [](json& d) {
       d["nodes"][1]["scale"] = {1, 1, 1, 1};
     },
     "node 1: scale has 4 numbers instead of 3"},
    {"short rotation",
     [](json& d) {
       d["nodes"][1]["rotation"] = {0, 0, 1};
     },
     "node 1: rotation has 3 numbers"},
    {"scale as number", [](json& d) { d["nodes"][1]["scale"] = 2; }, "node 1: scale is not an array"},
    {"translation of text",
     [](json& d) {
       d["nodes"][1]["translation"] = {0, "1", 0};
     },
     "node 1: translation holds something else than a number"},
    {"null",
     [](json& d) {
       d["nodes"][1]["translation"] = {0, nullptr, 0};
     },
     "node 1: translation holds something"},
};

// What other readers of glTF take too, with a note each; the expected places of the meshes of nodes 1 and 2.
struct Oddity {
  const char* name;
  std::function<void(json&)> bend;
  std::vector<double> x;  // of the placements
  const char* note;
};

const std::vector<Oddity> oddities = {
    {"cycle", [](json& d) { d["nodes"][1]["children"] = {0}; }, {3}, "node 0 \"root\" left out: it hangs on a cycle"},
    {"own child", [](json& d) { d["nodes"][2]["children"] = {2}; }, {12}, "node 2 left out: it hangs on a cycle"},
    {"two parents",
     [](json& d) { d["nodes"][2]["children"] = {1}; },
     {12, 3},
     "node 1: is a child of node 0 and again of node 2; the first taken"},
    {"twice a child",
     [](json& d) {
       d["nodes"][0]["children"] = {1, 1};
     },
     {12, 3},
     ""},
    {"root with a parent",
     [](json& d) {
       d["scenes"][0]["nodes"] = {0, 1, 2};
     },
     {12, 3},
     "node 1: is a root of scene 0 and a child of node 0, in whose frame it stands"},
    {"only the child", [](json& d) { d["scenes"][0]["nodes"] = {1}; }, {12}, "node 1: is a root of scene 0"},
    {"no rotation",
     [](json& d) {
       d["nodes"][1]["rotation"] = {0, 0, 0, 0};
     },
     {12, 3},
     "node 1: its rotation has no direction; taken as none"},
    {"nearly affine",
     [](json& d) {
       d["nodes"][2] = {{"mesh", 0}, {"matrix", {1, 0, 0, 1e-17, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 0.99999994}}};
     },
     {12, 3},
     ""},
    {"projective",
     [](json& d) {
       d["nodes"][2] = {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.5, 3, 0, 0, 1}}};
     },
     {12, 3},
     "node 2: the last row of its matrix is not 0, 0, 0, 1; taken as if it were"},
    {"both",
     [](json& d) { d["nodes"][2]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1}; },
     {12, 5},
     "node 2: has both a matrix and a translation; the matrix taken"},
    {"null",
     [](json& d) {
       d["nodes"][2]["matrix"] = nullptr;
       d["nodes"][1]["skin"] = nullptr;
     },
     {12, 3},
     ""},
};

TEST_F(GltfNodes, OdditiesCostANoteAndNotThePicture) {
  for (const Oddity& oddity : oddities) {
    SCOPED_TRACE(oddity.name);
    GltfBuilder builder = with_nodes({{{"name", "root"}, {"translation", {10, 0, 0}}, {"children", {1}}},
                                      {{"mesh", 0}, {"translation", {2, 0, 0}}},
                                      {{"mesh", 0}, {"translation", {3, 0, 0}}}});
    builder.document["scenes"] = {{{"nodes", {0, 2}}}};
    oddity.bend(builder.document);
    const Ingested ingested = read(builder);
    std::vector<double> x;
    for (const Placement& placement : ingested.placements) x.push_back(placement.transform[3]);
    EXPECT_EQ(x, oddity.x);
    if (*oddity.note == 0) EXPECT_TRUE(ingested.notes.empty());
    else
      EXPECT_TRUE(!ingested.notes.empty() && ingested.notes[0].starts_with(oddity.note))
          << (ingested.notes.empty() ? "" : ingested.notes[0]);
  }
}

TEST_F(GltfNodes, AShiftMovesTheMeshAndItsPlacementsBack) {
  const GltfBuilder builder =
      with_nodes({{{"mesh", 0}}, {{"mesh", 0}, {"scale", {2, 2, 2}}, {"translation", {0, 0, 9}}}});
  const Ingested ingested = read(builder, {.placements = true, .shift = {0.5, 0, -3}});
  EXPECT_EQ(ingested.meshes[0].positions[1], (Position{0.5f, 0, 3}));
  EXPECT_EQ(ingested.meshes[0].shift, (std::array<double, 3>{0.5, 0, -3}));
  ASSERT_EQ(ingested.placements.size(), 2u);
  EXPECT_EQ(ingested.placements[0].transform, (Transform{1, 0, 0, 0.5f, 0, 1, 0, 0, 0, 0, 1, -3}));
  EXPECT_EQ(ingested.placements[1].transform, (Transform{2, 0, 0, 1, 0, 2, 0, 0, 0, 0, 2, 3}));
}

TEST_F(GltfNodes, DefectsCostAllPlacesAndNoMesh) {
  for (const NodeDefect& defect : node_defects) {
    SCOPED_TRACE(defect.name);
    GltfBuilder builder = with_nodes({{{"name", "root"}, {"children", {1}}}, {{"mesh", 0}}, {{"mesh", 0}}});
    builder.document["scenes"] = {{{"nodes", {0, 2}}}};
    EXPECT_EQ(read(builder).placements.size(), 2u);
    defect.bend(builder.document);
    const Ingested ingested = read(builder);
    EXPECT_TRUE(ingested.placements.empty());
    EXPECT_EQ(ingested.meshes.size(), 1u);
    const std::string& note = ingested.notes.back();
    EXPECT_TRUE(note.starts_with("its nodes cannot be read") && note.find(defect.reason) != std::string::npos) << note;
    EXPECT_TRUE(read(builder, {}).notes.empty());
  }
}

TEST_F(GltfNodes, WhatOnlyLightsNeedCostsNoPlaces) {
  for (const char* defect : {R"({"extras": {"area_light": {"width": "big"}}})",
                             R"({"extensions": {"KHR_lights_punctual": {"light": 7}}})"}) {
    json node = {{"mesh", 0}};
    node.update(json::parse(defect));
    const GltfBuilder builder = with_nodes(json::array({node}));
    EXPECT_EQ(read(builder).placements.size(), 1u) << defect;
    const Ingested lit = read(builder, {.placements = true, .lights = true});
    EXPECT_TRUE(lit.lights.empty() && !lit.notes.empty()) << defect;
  }
}

TEST_F(GltfNodes, NumbersBeyondDoubleAreRefused) {
  std::string text = with_nodes({{{"mesh", 0}, {"translation", {12345, 0, 0}}}}).embedded();
  text.replace(text.find("12345"), 5, "1e999");
  const Result<Ingested> result = ingest(write("file.gltf", text), {.placements = true});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::invalid_file);
}

TEST_F(GltfNodes, OffByDefault) {
  const Ingested ingested = read(with_nodes(json::array({turned})), {});
  EXPECT_TRUE(ingested.placements.empty());
  EXPECT_TRUE(ingested.notes.empty());
}

TEST_F(GltfNodes, PlacementsSurviveTheChildProcess) {
  const auto path = write("file.gltf", with_nodes({turned, {{"mesh", 0}}}).embedded());
  const Result<Ingested> direct = ingest(path, {.placements = true});
  const Result<Ingested> isolated = ingest_isolated(path, {.placements = true});
  ASSERT_TRUE(direct.ok() && isolated.ok());
  EXPECT_EQ(isolated->placements.size(), 2u);
  EXPECT_EQ(isolated->placements, direct->placements);
}

TEST_F(GltfNodes, OtherFormatsStandAsTheyAre) {
  const auto path = write("file.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Result<Ingested> result = ingest(path, {.placements = true});
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->placements, (std::vector<Placement>{{0, identity}}));
  EXPECT_TRUE(ingest(path)->placements.empty());
}

// A node's light, in the scene's frame.
class GltfLights : public GltfNodes {
 protected:
  static GltfBuilder with_lights(const json& lights, const json& nodes) {
    GltfBuilder builder = with_nodes(nodes);
    builder.document["extensions"]["KHR_lights_punctual"]["lights"] = lights;
    return builder;
  }
  static json node_of_light(int light, json node = json::object()) {
    node["extensions"]["KHR_lights_punctual"]["light"] = light;
    return node;
  }
  std::vector<SceneLight> lights(const GltfBuilder& builder) { return read(builder, {.lights = true}).lights; }
};

TEST_F(GltfLights, PunctualOnesStandWhereTheirNodesDo) {
  const json all = {{{"type", "point"}, {"range", 9}},
                    {{"type", "directional"}},
                    {{"type", "spot"}, {"spot", {{"outerConeAngle", std::acos(0.5)}}}}};
  const json down = {{"translation", {1, 2, 3}}, {"rotation", {-half, 0, 0, half}}};  // -z → -y
  const auto found =
      lights(with_lights(all, {{{"mesh", 0}}, node_of_light(0, down), node_of_light(1, down), node_of_light(2, down)}));
  ASSERT_EQ(found.size(), 3u);
  using Shape = SceneLight::Shape;
  EXPECT_EQ(found[0].shape, Shape::point);
  EXPECT_EQ(found[1].shape, Shape::directional);
  EXPECT_EQ(found[2].shape, Shape::point);
  EXPECT_EQ(found[0].position, (SceneLight::Vector{1, 2, 3}));
  EXPECT_EQ(found[0].range, 9);
  EXPECT_EQ(found[0].cone_cosine, -1);
  EXPECT_NEAR(found[2].cone_cosine, 0.5, 1e-12);
  for (size_t i : {1, 2}) EXPECT_NEAR(found[i].direction[1], -1, 1e-12);
}

TEST_F(GltfLights, AreaLightsAndTheSkyStandInExtras) {
  GltfBuilder builder =
      with_nodes({{{"mesh", 0}, {"extras", "anything"}},
                  {{"scale", {2, 3, 1}}, {"extras", {{"area_light", {{"width", 4}, {"height", 1}}}}}}});
  builder.document["scenes"] = {{{"nodes", {0, 1}}, {"extras", {{"sky_light", true}}}}};
  const auto found = lights(builder);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].shape, SceneLight::Shape::rectangle);
  EXPECT_EQ(found[0].direction, (SceneLight::Vector{0, 0, -1}));
  EXPECT_EQ(found[0].half_edges[0], (SceneLight::Vector{4, 0, 0}));
  EXPECT_EQ(found[0].half_edges[1], (SceneLight::Vector{0, 1.5, 0}));
  EXPECT_EQ(found[1].shape, SceneLight::Shape::sky);
  EXPECT_TRUE(read(builder).lights.empty()) << "not asked for";
}

TEST_F(GltfLights, SurviveTheChildProcess) {
  const auto path =
      write("file.gltf", with_lights({{{"type", "point"}}}, {{{"mesh", 0}}, node_of_light(0)}).embedded());
  const Result<Ingested> direct = ingest(path, {.lights = true}), isolated = ingest_isolated(path, {.lights = true});
  ASSERT_TRUE(direct.ok() && isolated.ok());
  EXPECT_EQ(isolated->lights.size(), 1u);
  EXPECT_EQ(isolated->lights, direct->lights);
}

TEST_F(GltfLights, WrongOnesLeaveNoneAndANote) {
  const json point = {{{"type", "point"}}};
  const std::tuple<json, json, const char*> faults[] = {
      {point, node_of_light(1), "light 1 does not exist"},
      {{{{"type", "lamp"}}}, node_of_light(0), "type \"lamp\" does not exist"},
      {{{{"type", "spot"}}}, node_of_light(0), "spot without a cone"},
      {{{{"type", "spot"}, {"spot", {{"outerConeAngle", 3}}}}}, node_of_light(0), "quarter turn"},
      {{{{"type", "point"}, {"range", -1}}}, node_of_light(0), "range is negative"},
      {{{{"type", "directional"}}}, node_of_light(0, {{"scale", {0, 0, 0}}}), "no direction"},
      {point, {{"extras", {{"area_light", {{"width", 1}}}}}}, "height is not greater"}};
  for (const auto& [all, node, note] : faults) {
    const Ingested ingested = read(with_lights(all, {{{"mesh", 0}}, node}), {.lights = true});
    EXPECT_TRUE(ingested.lights.empty()) << note;
    ASSERT_EQ(ingested.notes.size(), 1u) << note;
    EXPECT_NE(ingested.notes[0].find(note), std::string::npos) << ingested.notes[0];
  }
}

}  // namespace
}  // namespace vcd::test
