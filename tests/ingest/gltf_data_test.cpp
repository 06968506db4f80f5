// glTF and Draco files that users really have, read where they lie. The folder is not part of the project: it
// is named by the environment variable VCD_TEST_DATA or by the compile definition VCD_SHARED_DATA_DIR.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "gltf_builder.h"
#include "ingest/draco_mesh.h"
#include "ingest/gltf.h"

namespace vcd::test {
namespace {

using namespace baker;

const IngestOptions everything = {.treat_all_as_opaque = true};

class GltfData : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("VCD_TEST_DATA");
#ifdef VCD_SHARED_DATA_DIR
    if (folder == nullptr) folder = VCD_SHARED_DATA_DIR;
#endif
    if (folder == nullptr) GTEST_SKIP() << "no test data: set VCD_TEST_DATA to its folder";
    folder_ = folder;
    if (!std::filesystem::is_directory(folder_)) GTEST_SKIP() << "no test data in " << folder_;
  }

  Ingested read(const std::string& name) {
    const Result<Ingested> result = ingest(folder_ / name, everything);
    EXPECT_TRUE(result.ok()) << result.error().message;
    return result.ok() ? *result : Ingested{};
  }

  static size_t triangle_count(const Ingested& ingested) {
    size_t count = 0;
    for (const SourceMesh& mesh : ingested.meshes) count += mesh.triangles.size();
    return count;
  }

  void expect_same(const std::string& name_a, const std::string& name_b) {
    SCOPED_TRACE(name_b);
    const Ingested a = read(name_a), b = read(name_b);
    ASSERT_EQ(a.meshes.size(), b.meshes.size());
    ASSERT_FALSE(a.meshes.empty());
    for (size_t i = 0; i < a.meshes.size(); ++i) {
      EXPECT_EQ(a.meshes[i].positions, b.meshes[i].positions);
      EXPECT_EQ(a.meshes[i].triangles, b.meshes[i].triangles);
    }
  }

  std::filesystem::path folder_;
};

TEST_F(GltfData, OneAssetInThreeContainersIsOneMesh) {
  const std::string man = "gltf/Vulkan-Assets/CesiumMan/";
  expect_same(man + "glTF/CesiumMan.gltf", man + "glTF-Binary/CesiumMan.glb");
  expect_same(man + "glTF/CesiumMan.gltf", man + "glTF-Embedded/CesiumMan.gltf");
  // Two exports of one model, which number and round the vertices differently.
  for (const char* extension : {".gltf", ".glb"}) {
    EXPECT_EQ(triangle_count(read(std::string("gltf/Vulkan-Assets/retroufo") + extension)), 16'428u);
  }
}

TEST_F(GltfData, SkinnedAssetsAreLeftOutByDefault) {
  const Result<Ingested> result = ingest(folder_ / "gltf/Vulkan-Assets/CesiumMan/glTF-Binary/CesiumMan.glb");
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("1 primitive left out as deforming"), std::string::npos);
}

TEST_F(GltfData, TriangleCountsAreKnown) {
  const std::vector<std::pair<const char*, size_t>> files = {
      {"gltf/glTF-Transform/functions/test/in/DenseSphere.glb", 30'720},
      {"gltf/assimp/glTF2/draco/2CylinderEngine.gltf", 65'311},
      {"gltf/meshoptimizer/demo/pirate.glb", 5'010},
      {"gltf/glTF-Transform/extensions/test/in/BoxMeshopt.gltf", 12},
      {"gltf/assimp/glTF2/MorphStressTest/glTF/MorphStressTest.gltf", 2'412},
      {"gltf/tinygltf/CubeImageUriSpaces/CubeImageUriSpaces.gltf", 12},
      {"paper/foliage/vulkan-assets/oaktree.gltf", 5'302},
  };
  for (const auto& [name, count] : files) EXPECT_EQ(triangle_count(read(name)), count) << name;
}

void expect_sound(const Ingested& ingested) {
  EXPECT_FALSE(ingested.meshes.empty());
  for (const SourceMesh& mesh : ingested.meshes) {
    EXPECT_FALSE(mesh.triangles.empty());
    for (const Position& p : mesh.positions) {
      ASSERT_TRUE(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]));
    }
    for (const TriangleIndices& t : mesh.triangles) {
      ASSERT_LT(std::max({t[0], t[1], t[2]}), mesh.positions.size());
    }
  }
}

TEST_F(GltfData, EveryFileIsSoundOrRefused) {
  size_t accepted = 0, refused = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_)) {
    const std::string extension = entry.path().extension().string();
    const bool draco = extension == ".drc";
    if (!draco && extension != ".gltf" && extension != ".glb") continue;
    SCOPED_TRACE(entry.path());
    const Result<Ingested> result = ingest(entry.path(), everything);
    ++(result.ok() ? accepted : refused);
    if (result.ok()) {
      expect_sound(*result);
    } else {
      EXPECT_NE(result.error().code, ErrorCode::runtime) << result.error().message;
    }
  }
  EXPECT_GE(accepted, 1u);
  RecordProperty("accepted", static_cast<int>(accepted));
  RecordProperty("refused", static_cast<int>(refused));
}

// The validator's reports tell which files are broken. Those with an error at what decides on triangles must
// not pass.
TEST_F(GltfData, WhatTheValidatorCallsBrokenGeometryIsRefused) {
  const std::vector<std::string> geometry_errors = {"ACCESSOR_INDEX_OOB",
                                                    "ACCESSOR_INVALID_FLOAT",
                                                    "BUFFER_VIEW_TOO_LONG",
                                                    "BUFFER_BYTE_LENGTH_MISMATCH",
                                                    "ACCESSOR_TOO_LONG",
                                                    "VALUE_MULTIPLE_OF",
                                                    "GLB_",
                                                    "UNKNOWN_ASSET_MAJOR_VERSION"};
  size_t checked = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "hostile")) {
    const std::string name = entry.path().string();
    if (!name.ends_with(".report.json")) continue;
    std::ifstream stream(entry.path());
    const json report = json::parse(stream, nullptr, false);
    if (report.is_discarded()) continue;
    bool broken = false;
    for (const json& message : report["issues"]["messages"]) {
      const std::string code = message.value("code", "");
      const std::string pointer = message.value("pointer", "");
      const bool unresolved = code == "UNRESOLVED_REFERENCE" && pointer.starts_with("/meshes/");
      const bool listed = std::any_of(geometry_errors.begin(), geometry_errors.end(),
                                      [&](const std::string& prefix) { return code.starts_with(prefix); });
      broken = broken || (message.value("severity", 9) == 0 && (unresolved || listed));
    }
    const std::filesystem::path file = name.substr(0, name.size() - std::string(".report.json").size());
    if (!broken || !std::filesystem::exists(file)) continue;
    ++checked;
    EXPECT_FALSE(ingest(file, everything).ok()) << file;
  }
  EXPECT_GE(checked, 10u);
}

}  // namespace
}  // namespace vcd::test
