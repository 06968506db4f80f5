#include "info/surface.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "support/hostile_meshes.h"

namespace vcd::test {
using namespace baker;
using namespace tools;
namespace {

double area(const std::vector<Position>& positions, const TriangleIndices& t) {
  std::array<double, 3> a, b;
  for (size_t i = 0; i < 3; ++i) {
    a[i] = double{positions[t[1]][i]} - positions[t[0]][i];
    b[i] = double{positions[t[2]][i]} - positions[t[0]][i];
  }
  return std::hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]) / 2;
}

TEST(DrawnSurface, IsTheMeshCutFiner) {
  const PreparedMesh mesh = *prepare(cube());
  const DrawnSurface surface = drawn_surface(mesh, 100'000);
  EXPECT_FALSE(surface.thinned);
  EXPECT_EQ(surface.triangles.size(), 12u * 1024);  // the most below 20,000
  ASSERT_EQ(surface.source.size(), surface.triangles.size());
  std::vector<double> areas(mesh.triangles.size());
  for (size_t t = 0; t < surface.triangles.size(); ++t)
    areas[surface.source[t]] += area(surface.positions, surface.triangles[t]);
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    EXPECT_NEAR(areas[t], area(mesh.positions, mesh.triangles[t]), 1e-4 * areas[t]);
  EXPECT_EQ(drawn_surface(mesh, 47).triangles.size(), 12u);
  EXPECT_EQ(drawn_surface(mesh, 48).triangles.size(), 48u);
}

TEST(DrawnSurface, IsThinnedToTheMostThatMayBeDrawn) {
  const PreparedMesh mesh = *prepare(sphere(60, 90));
  for (const size_t most : {size_t{1}, size_t{500}, mesh.triangles.size() - 1}) {
    const DrawnSurface surface = drawn_surface(mesh, most);
    EXPECT_TRUE(surface.thinned);
    EXPECT_LE(surface.triangles.size(), most);
    EXPECT_GE(surface.triangles.size(), most / 4);
    ASSERT_EQ(surface.source.size(), surface.triangles.size());
    for (size_t t = 0; t < surface.triangles.size(); ++t) {
      const Position& first = surface.positions[surface.triangles[t][0]];
      const TriangleIndices& source = mesh.triangles.at(surface.source[t]);
      EXPECT_TRUE(std::ranges::any_of(source, [&](uint32_t corner) { return mesh.positions[corner] == first; }));
    }
  }
}

}  // namespace
}  // namespace vcd::test
