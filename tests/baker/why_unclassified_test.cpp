#include <vcd/baker/why_unclassified.h>

#include <set>

#include <gtest/gtest.h>

#include "support/hostile_meshes.h"

namespace vcd::test {
using namespace baker;
namespace {

// All cells of a level between the two faces of the z axis.
std::vector<Cell> cells_along_z(uint32_t level) {
  std::vector<Cell> cells;
  const uint32_t n = 1u << level;
  for (uint32_t i = 0; i < n * n * n * n; ++i)
    cells.push_back({14, level, i / (n * n * n), i / (n * n) % n, i / n % n, i % n});
  return cells;
}

// Upright rectangles in the plane z = 0: from x = 0 to each pair's numbers, y from 0 to 1. The corners of the whole are
// marked far in front and behind, so that the box is 1 wide.
PreparedMesh strips(const std::vector<std::pair<float, float>>& ranges) {
  SourceMesh mesh;
  const auto add = [&](Position a, Position b, Position c) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {a, b, c});
    mesh.triangles.push_back({first, first + 1, first + 2});
  };
  for (const auto& [low, high] : ranges) {
    add({low, 0, 0}, {high, 0, 0}, {high, 1, 0});
    add({low, 0, 0}, {high, 1, 0}, {low, 1, 0});
  }
  add({0, 0, 0.5f}, {1e-4f, 0, 0.5f}, {0, 1e-4f, 0.5f});
  add({1, 1, -0.5f}, {1 - 1e-4f, 1, -0.5f}, {1, 1 - 1e-4f, -0.5f});
  return *prepare(std::move(mesh));
}

std::set<Why> whys(const PreparedMesh& mesh, const std::vector<Cell>& cells) {
  const auto found = why_unclassified(mesh, cells);
  EXPECT_TRUE(found);
  return {found->begin(), found->end()};
}

TEST(WhyUnclassified, TellsOneEdgeFromMany) {
  const std::vector<Cell> middle = {{14, 1, 0, 0, 0, 0}};
  EXPECT_EQ(whys(strips({{0, 0.25f}}), middle), std::set{Why::silhouette});
  EXPECT_EQ(whys(strips({{0, 0.1f}, {0.2f, 0.3f}, {0.4f, 0.5f}}), middle), std::set{Why::foliage});
}

TEST(WhyUnclassified, FindsWhatAProofKnows) {
  // A wall that reaches beyond the box's middle cells on all sides.
  EXPECT_EQ(whys(strips({{0, 1}}), {{14, 3, 3, 3, 3, 3}}), std::set{Why::known});
}

TEST(WhyUnclassified, FindsSheetsThatEnd) {
  // Two sheets, side by side with no common corner, block all lines together and none alone.
  EXPECT_EQ(whys(strips({{0, 0.45f}, {0.45f, 1}}), {{14, 3, 3, 3, 3, 3}}), std::set{Why::known});  // welded
  EXPECT_EQ(whys(strips({{0, 0.45f}, {0.44f, 1}}), {{14, 3, 3, 3, 3, 3}}), std::set{Why::boundary});
  EXPECT_FALSE(whys(*prepare(on_grid(sphere(12, 24), 0x1p-8f)), cells_along_z(3)).contains(Why::boundary));
}

TEST(WhyUnclassified, StopsWhenTold) {
  const auto found = why_unclassified(*prepare(cube()), cells_along_z(2), [] { return true; });
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::runtime);
}

}  // namespace
}  // namespace vcd::test
