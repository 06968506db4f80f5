#include <vcd/verify/check.h>

#include <gtest/gtest.h>

#include <cmath>

#include <sys/resource.h>

#include <vcd/baker/bake.h>
#include <vcd/baker/hierarchy.h>
#include <vcd/writer/writer.h>

#include "support/meshes.h"

namespace vcd::verify {

using namespace baker;

namespace {

class CheckBytes : public ::testing::Test {
 protected:
  CheckBytes() {
    meshes_.push_back(*prepare(test::cube()));
    BakeOptions options;
    options.depth = 2;
    options.embed_geometry = true;
    const auto object = bake(meshes_[0], options);
    SidecarToWrite sidecar;
    sidecar.objects = {object->to_write()};
    bytes_ = std::move(*sidecar_bytes(sidecar));
    options_.audit.lines = 9000;
  }

  Outcome check(const std::vector<PreparedMesh>& meshes) {
    return check_bytes({bytes_.data.get(), bytes_.size}, meshes, options_);
  }

  std::vector<PreparedMesh> meshes_;
  AlignedBytes bytes_;
  CheckOptions options_;
};

long children() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  return usage.ru_minflt;
}

TEST_F(CheckBytes, AuditsTheMeshWithoutAnotherProcess) {
  const long before = children();
  const Outcome outcome = check(meshes_);
  EXPECT_EQ(outcome.exit_code(), 0);
  ASSERT_EQ(outcome.objects.size(), 1u);
  ASSERT_TRUE(outcome.objects[0].audit);
  EXPECT_EQ(outcome.objects[0].audit->sum(false).segments + outcome.objects[0].audit->sum(true).segments, 9000u);
  EXPECT_EQ(children(), before);
}

TEST_F(CheckBytes, IsStaleAgainstAnotherMesh) {
  EXPECT_TRUE(check({*prepare(test::sphere())}).has(IssueId::stale));
  EXPECT_TRUE(check({}).has(IssueId::stale));
}

TEST_F(CheckBytes, SaysWhatIsWrongWithTheBytes) {
  bytes_.data.get()[bytes_.size / 2] ^= std::byte{1};
  const Outcome outcome = check(meshes_);
  EXPECT_EQ(outcome.exit_code(), static_cast<int>(ErrorCode::invalid_file));
  EXPECT_TRUE(outcome.objects.empty());
}

TEST_F(CheckBytes, HoldsHorizonsAgainstTheMesh) {
  // A floor with walls on its four sides, above and below, that lean outwards.
  SourceMesh box{"box", 0, {}, {{0, 1, 2}, {0, 2, 3}}};
  for (const float z : {0.0f, 0.3f, -0.3f})
    for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
      const float out = z == 0 ? 0.0f : 0.5f;
      box.positions.push_back({x ? 1 + out : -out, y ? 1 + out : -out, z});
    }
  for (uint32_t i = 0; i < 4; ++i) {
    const uint32_t j = (i + 1) % 4;
    box.triangles.push_back({i + 8, j + 8, j + 4}), box.triangles.push_back({i + 8, j + 4, i + 4});
  }
  std::vector<PreparedMesh> meshes;
  meshes.push_back(*prepare(std::move(box)));
  BakeOptions options;
  options.depth = 2, options.method = Method::proven, options.horizons = true;
  const auto object = bake(meshes[0], options);
  SidecarToWrite sidecar;
  sidecar.objects = {object->to_write()};
  const Bytes sound = sidecar.objects[0].horizon;
  ASSERT_FALSE(sound.empty());
  bytes_ = std::move(*sidecar_bytes(sidecar));
  EXPECT_TRUE(check(meshes).issues.empty());
  HierarchySection lower((sound.size() + kUnitBytes - 1) / kUnitBytes);  // aligned bytes
  std::memcpy(lower.data(), sound.data(), sound.size());
  auto& header = *reinterpret_cast<HorizonHeader*>(lower.data());
  for (auto& table : header.slope)
    for (float& slope : table) slope *= 0.3f;
  sidecar.objects[0].horizon = bytes_of(lower).first(sound.size());
  bytes_ = std::move(*sidecar_bytes(sidecar));
  const Outcome outcome = check(meshes);
  ASSERT_EQ(outcome.issues.size(), 1u);
  EXPECT_EQ(outcome.issues[0].info, &issue_info(IssueId::wrong_horizon));
}

// Each hierarchy is one that a reader must take, in a sidecar of the cube.
TEST_F(CheckBytes, HoldsTheHierarchyAgainstTheMesh) {
  const auto fault_of = [&](HierarchySection section) {
    BakeOptions options;
    options.depth = 2;
    const auto object = bake(meshes_[0], options);
    SidecarToWrite sidecar;
    sidecar.objects = {object->to_write()};
    sidecar.objects[0].hierarchy = bytes_of(section);
    bytes_ = std::move(*sidecar_bytes(sidecar));
    const Outcome outcome = check(meshes_);
    EXPECT_LE(outcome.issues.size(), 1u);
    if (outcome.issues.empty()) return std::string();
    EXPECT_EQ(outcome.issues[0].info, &issue_info(IssueId::hierarchy_triangles));
    return outcome.issues[0].detail;
  };
  const HierarchySection good = *build_hierarchy(meshes_[0]);
  EXPECT_EQ(fault_of(good), "");

  SourceMesh turned = test::cube();  // one face's diagonal
  turned.triangles[0] = {0, 2, 3}, turned.triangles[1] = {0, 1, 3};
  EXPECT_NE(fault_of(*build_hierarchy(*prepare(std::move(turned)))).find("a triangle that the mesh has not"),
            std::string::npos);
  SourceMesh other = test::cube();
  other.positions.push_back({0.5f, 0.5f, std::nextafter(0.5f, 1.0f)});
  other.triangles[0] = {0, 2, 8};
  EXPECT_NE(fault_of(*build_hierarchy(*prepare(std::move(other)))).find("a vertex that the mesh has not"),
            std::string::npos);
  HierarchySection twice = good;
  const HierarchyView view = view_of(twice);
  auto& leaf = const_cast<SmallLeaf&>(view.small_leaf(view.node(kRootUnit).child[0]));
  ASSERT_EQ(leaf.present, (1u << 12) - 1);
  for (auto& corners : leaf.corner) corners[11] = corners[10];
  EXPECT_NE(fault_of(twice).find("a triangle that another one holds too"), std::string::npos);
}

TEST_F(CheckBytes, EndsAsNotVerifiedWhenStopped) {
  options_.stop = [] { return true; };
  EXPECT_TRUE(check(meshes_).has(IssueId::not_verified));
}

}  // namespace
}  // namespace vcd::verify
