#include "prepare/topology.h"

#include <map>
#include <random>

#include <gtest/gtest.h>

#include "support/hostile_meshes.h"

namespace vcd::test {
using namespace baker;
namespace {

std::vector<uint32_t> paired(const SourceMesh& mesh) { return pair_edges(mesh.positions, mesh.triangles); }
size_t boundaries(const std::vector<uint32_t>& neighbour) {
  return static_cast<size_t>(std::count(neighbour.begin(), neighbour.end(), kBoundary));
}
std::pair<uint32_t, uint32_t> edge_of(const SourceMesh& mesh, size_t slot) {
  const TriangleIndices& t = mesh.triangles[slot / 3];
  return std::minmax(t[slot % 3], t[(slot % 3 + 1) % 3]);
}

// Triangles at the edge from (0, 0, 0) to (0, 0, 1), at these angles in degrees.
SourceMesh book(const std::vector<double>& pages) {
  SourceMesh mesh{"book", 0, {{0, 0, 0}, {0, 0, 1}}, {}};
  for (double page : pages) {
    const double phi = page * std::numbers::pi / 180;
    mesh.positions.push_back({static_cast<float>(std::cos(phi)), static_cast<float>(std::sin(phi)), 0.3f});
    mesh.triangles.push_back({0, 1, static_cast<uint32_t>(mesh.positions.size() - 1)});
  }
  return mesh;
}

TEST(PairEdges, IsSymmetricAndKeepsToOneEdgeOnEveryMesh) {
  for (const PreparedMesh& prepared : hostile_meshes()) {
    const SourceMesh mesh{"", 0, prepared.positions, prepared.triangles};
    const auto neighbour = paired(mesh);
    ASSERT_EQ(neighbour.size(), 3 * mesh.triangles.size());
    std::map<std::pair<uint32_t, uint32_t>, std::pair<size_t, size_t>> left;  // sides and boundary sides of each edge
    for (size_t slot = 0; slot < neighbour.size(); ++slot) {
      auto& [sides, open] = left[edge_of(mesh, slot)];
      ++sides;
      open += neighbour[slot] == kBoundary;
      if (neighbour[slot] == kBoundary) continue;
      ASSERT_NE(neighbour[slot], slot / 3);
      int back = 0;  // the neighbour's side of the same edge leads back, and only that one
      for (size_t i = 0; i < 3; ++i) {
        const size_t other = 3 * size_t{neighbour[slot]} + i;
        back += edge_of(mesh, other) == edge_of(mesh, slot) && neighbour[other] == slot / 3;
      }
      EXPECT_EQ(back, 1);
    }
    for (const auto& [edge, count] : left) EXPECT_EQ(count.second, count.first > 16 ? count.first : count.first % 2);
  }
}

TEST(PairEdges, LeavesNoBoundaryOnAClosedMesh) {
  EXPECT_EQ(boundaries(paired(cube())), 0u);
  EXPECT_EQ(boundaries(paired(inverted(cube()))), 0u);
  EXPECT_EQ(boundaries(paired(bow_tie())), 0u);
}

TEST(PairEdges, FindsTheRimOfAnOpenMesh) {
  EXPECT_EQ(boundaries(paired(flat(8))), 32u);
  EXPECT_EQ(boundaries(paired(triangle())), 3u);
  EXPECT_EQ(boundaries(paired(pierced(cube(), 5))), 3u);
}

TEST(PairEdges, GoesRoundAMoebiusStripWhateverItsWinding) { EXPECT_EQ(boundaries(paired(moebius(24))), 48u); }

TEST(PairEdges, DoesNotCareForWinding) {
  SourceMesh mesh = cube();
  const auto expected = paired(mesh);
  for (size_t t = 0; t < mesh.triangles.size(); t += 2) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  const auto actual = paired(mesh);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<uint32_t, 3> a{expected[3 * t], expected[3 * t + 1], expected[3 * t + 2]};
    std::array<uint32_t, 3> b{actual[3 * t], actual[3 * t + 1], actual[3 * t + 2]};
    std::sort(a.begin(), a.end()), std::sort(b.begin(), b.end());
    EXPECT_EQ(a, b);
  }
}

TEST(PairEdges, PairsThoseThatContinueEachOtherStraightest) {
  // 10 with 185 and 100 with 290; 40 is left over.
  const auto four = paired(book({10, 100, 185, 290}));
  EXPECT_EQ(four[0], 2u);
  EXPECT_EQ(four[6], 0u);
  EXPECT_EQ(four[3], 3u);
  EXPECT_EQ(four[9], 1u);
  const auto three = paired(book({10, 40, 185}));
  EXPECT_EQ(three[0], 2u);
  EXPECT_EQ(three[6], 0u);
  EXPECT_EQ(three[3], kBoundary);
  const auto five = paired(book({10, 40, 100, 185, 290}));
  EXPECT_EQ(five[3], kBoundary);
}

TEST(PairEdges, TakesSixteenTrianglesAtAnEdgeAndNoMore) {
  std::vector<double> pages;
  for (int i = 0; i < 15; ++i) pages.push_back(20 * i);
  EXPECT_EQ(boundaries(paired(book(pages))), 2 * 15u + 1);
  pages.push_back(305);
  EXPECT_EQ(boundaries(paired(book(pages))), 2 * 16u);
  pages.push_back(333);
  EXPECT_EQ(boundaries(paired(book(pages))), 3 * 17u);
}

TEST(PairEdges, PairsTheTwoWindingsOfOneTriangleWithEachOther) {
  SourceMesh mesh = triangle();
  mesh.triangles.push_back({0, 2, 1});
  EXPECT_EQ(boundaries(paired(mesh)), 0u);
}

}  // namespace
}  // namespace vcd::test
