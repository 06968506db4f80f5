#include <vcd/library/cost.h>

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "support/files.h"

namespace vcd::library {
namespace {

namespace fs = std::filesystem;

class GuessedCost : public ::testing::Test {
 protected:
  double seconds(const std::string& name, std::string content, size_t bytes, const std::string& depth) {
    content.resize(bytes, ' ');
    const fs::path path = folder_.path() / name;
    std::ofstream(path, std::ios::binary) << content;
    Asset asset{path, path, {}};
    EXPECT_FALSE(set(asset.settings, "depth", depth));
    asset.settings.audit_lines = 0;
    return guess_cost(asset).seconds;
  }

  static std::string meshes(int count) {
    std::string json = R"({"meshes": [)";
    for (int i = 0; i < count; ++i) json += R"({"primitives": [{"attributes": {"POSITION": 0}}]},)";
    return json + "]}";
  }
  static std::string glb(const std::string& json, uint32_t said) {
    std::string file = "glTF\2xxxxxxx????JSON" + json;
    std::memcpy(file.data() + 12, &said, sizeof said);
    return file;
  }

  test::TemporaryFolder folder_;
};

TEST_F(GuessedCost, GrowsWithDepthAndTriangles) {
  EXPECT_GT(seconds("a.ply", "", 400000, "6"), 5 * seconds("a.ply", "", 400000, "5"));
  EXPECT_GT(seconds("a.ply", "", 4000000, "4"), 1.5 * seconds("a.ply", "", 400000, "4"));
}

TEST_F(GuessedCost, GrowsWithSubdivision) {
  const fs::path path = folder_.path() / "a.obj";
  std::ofstream(path) << std::string(300000, ' ');
  Asset asset{path, path, {}};
  const auto once = guess_cost(asset);
  asset.settings.subdivide = 2;
  EXPECT_GT(guess_cost(asset).memory_bytes, once.memory_bytes + 500 * 100000);
}

TEST_F(GuessedCost, EachMeshOfAGltfFileIsBakedForItself) {
  const double one = seconds("a.gltf", meshes(1), 100000, "4"), many = seconds("a.gltf", meshes(100), 100000, "4");
  EXPECT_GT(many, 10 * one);
  EXPECT_LT(many, 100 * one);  // they are smaller
  const std::string json = meshes(100);
  EXPECT_GT(seconds("a.glb", glb(json, static_cast<uint32_t>(json.size())), 100000, "4"), 10 * one);
  EXPECT_LT(seconds("a.glb", glb(meshes(1), 60) + json, 100000, "4"), 2 * one);  // only what lies in the JSON chunk
}

TEST_F(GuessedCost, IsGuessedOfAnythingThatIsCalledAMesh) {
  for (const uint32_t said : {0u, 7u, 0xffffffffu}) EXPECT_GT(seconds("a.glb", glb("{", said), 30, "4"), 0);
  EXPECT_GT(seconds("a.glb", "", 0, "4"), 0);
  EXPECT_GT(guess_cost({folder_.path() / "none.gltf", {}, {}}).seconds, 0);
  EXPECT_GT(guess_cost({folder_.path(), {}, {}}).seconds, 0);
}

}  // namespace
}  // namespace vcd::library
