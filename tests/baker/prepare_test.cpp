#include <vcd/baker/prepare.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <limits>

#include <gtest/gtest.h>

#include <vcd/format/weld.h>

#include "support/meshes.h"

namespace vcd::test {
using namespace baker;
namespace {

PreparedMesh must_prepare(SourceMesh mesh) {
  auto prepared = prepare(std::move(mesh));
  EXPECT_TRUE(prepared.ok());
  return std::move(*prepared);
}

// The same triangles with vertices duplicated and everything in another order.
SourceMesh shuffled(const SourceMesh& mesh, uint32_t seed) {
  std::mt19937 random(seed);
  SourceMesh out{"another name", 5, {}, {}};
  std::vector<TriangleIndices> triangles = mesh.triangles;
  std::shuffle(triangles.begin(), triangles.end(), random);
  for (TriangleIndices t : triangles) {
    std::rotate(t.begin(), t.begin() + random() % 3, t.end());
    if (random() % 2) std::swap(t[0], t[1]);
    TriangleIndices indices;
    for (int c = 0; c < 3; ++c) {
      indices[c] = static_cast<uint32_t>(out.positions.size());
      out.positions.push_back(mesh.positions[t[c]]);
    }
    out.triangles.push_back(indices);
  }
  return out;
}

TEST(Prepare, WeldsBitIdenticalPositionsOnly) {
  SourceMesh mesh = shuffled(cube(), 1);
  EXPECT_EQ(must_prepare(mesh).positions.size(), 8u);
  SourceMesh near = shuffled(cube(), 1);
  near.positions[0][0] = std::nextafter(near.positions[0][0], 10.0f);
  EXPECT_EQ(must_prepare(near).positions.size(), 9u);
}

TEST(Prepare, TakesMinusZeroForZero) {
  SourceMesh mesh = shuffled(cube(), 2);
  for (Position& p : mesh.positions)
    for (float& x : p)
      if (x == 0 && (&p - mesh.positions.data()) % 2) x = -0.0f;
  EXPECT_EQ(must_prepare(mesh).geometry_hash, must_prepare(cube()).geometry_hash);
}

TEST(Prepare, DropsAndCountsDuplicatesAndZeroAreas) {
  SourceMesh mesh = cube();
  mesh.triangles.push_back({1, 0, 2});  // the first again, wound the other way
  mesh.triangles.push_back({3, 3, 4});  // two equal corners
  mesh.positions.push_back({2, 2, 2});  // on the line through corners 0 and 7
  mesh.triangles.push_back({0, 7, 8});
  const PreparedMesh prepared = must_prepare(mesh);
  EXPECT_EQ(prepared.duplicate_triangles, 1u);
  EXPECT_EQ(prepared.zero_area_triangles, 2u);
  EXPECT_EQ(prepared.geometry_hash, must_prepare(cube()).geometry_hash);
}

TEST(Prepare, KeepsSliversThatHaveAnArea) {
  EXPECT_TRUE(has_zero_area({0, 0, 0}, {1, 1, 1}, {3, 3, 3}));
  EXPECT_TRUE(has_zero_area({1e-20f, 0, 0}, {2e-20f, 0, 0}, {3e-20f, 0, 0}));
  EXPECT_FALSE(has_zero_area({0, 0, 0}, {1, 1, 1}, {3, 3, std::nextafter(3.0f, 4.0f)}));
  EXPECT_FALSE(has_zero_area({1, 1, 1}, {1 + 0x1p-23f, 1, 1}, {1, 1 + 0x1p-23f, 1}));
  // Far apart in size: whatever the order of the corners.
  const Position a = {0, 0, 0}, b = {1e-20f, 0, 0}, c = {1, 1, 0};
  for (const auto& [p, q, r] : {std::array{a, b, c}, {b, c, a}, {c, a, b}, {b, a, c}, {a, c, b}, {c, b, a}})
    EXPECT_FALSE(has_zero_area(p, q, r));
  // Products that agree to 53 bits and differ beyond.
  EXPECT_FALSE(has_zero_area({0, 0, 0}, {0x1.000002p0f, 0x1.000002p24f, 0}, {0x1.000004p0f, 0x1.000004p24f + 2, 0}));
}

TEST(Prepare, DoesNotDependOnOrderNamesOrWinding) {
  for (const SourceMesh& mesh : {cube(), sphere(), leaves(50)}) {
    const PreparedMesh original = must_prepare(mesh), other = must_prepare(shuffled(mesh, 3));
    EXPECT_EQ(original.geometry_hash, other.geometry_hash);
    EXPECT_EQ(original.positions, other.positions);
    EXPECT_EQ(original.triangles, other.triangles);  // what has one hash is baked to the same bytes
    EXPECT_EQ(original.box_min, other.box_min);
  }
  SourceMesh moved = cube();
  moved.positions[7][0] = std::nextafter(1.0f, 2.0f);
  EXPECT_NE(must_prepare(moved).geometry_hash, must_prepare(cube()).geometry_hash);
}

TEST(Prepare, PadsTheBox) {
  std::mt19937 random(4);
  for (int i = 0; i < 200; ++i) {
    SourceMesh mesh = leaves(3, static_cast<uint32_t>(random()));
    const float size = std::ldexp(1.0f, static_cast<int>(random() % 160) - 80);
    const float shift = random() % 2 ? 0 : size * std::ldexp(1.0f, static_cast<int>(random() % 22));
    const int flat = static_cast<int>(random() % 4);
    for (Position& p : mesh.positions)
      for (int a = 0; a < 3; ++a) p[a] = a == flat ? shift : p[a] * size + shift;
    auto prepared = prepare(std::move(mesh));
    if (!prepared) continue;  // all collapsed to nothing by the shift
    for (int a = 0; a < 3; ++a) {
      const double extent = static_cast<double>(prepared->box_max[a]) - prepared->box_min[a];
      for (const Position& p : prepared->positions) {
        EXPECT_GE(p[a] - static_cast<double>(prepared->box_min[a]), extent * 0x1p-11);
        EXPECT_GE(static_cast<double>(prepared->box_max[a]) - p[a], extent * 0x1p-11);
      }
    }
  }
}

TEST(Prepare, GivesFlatMeshesAThickness) {
  SourceMesh quad{"quad", 0, {{0, 0, 5}, {1, 0, 5}, {1, 1, 5}, {0, 1, 5}}, {{0, 1, 2}, {0, 2, 3}}};
  const PreparedMesh prepared = must_prepare(quad);
  EXPECT_GE(prepared.box_max[2] - prepared.box_min[2], 0.001f * std::sqrt(2.0f));
}

TEST(Prepare, RefusesWhatHasNoAreaOrNoBox) {
  EXPECT_FALSE(prepare({"point", 0, {{1, 1, 1}}, {{0, 0, 0}}}).ok());
  SourceMesh huge = cube();
  for (Position& p : huge.positions)
    for (float& x : p) x = (x - 0.5f) * 3e38f * 2;
  const auto result = prepare(std::move(huge));
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::unsupported);
}

TEST(Prepare, RefusesMeshesFromMemoryThatAreNotSound) {
  SourceMesh far = triangle(), odd = triangle();
  far.triangles[0][1] = 3;
  odd.positions[2][0] = std::numeric_limits<float>::quiet_NaN();
  for (SourceMesh* mesh : {&far, &odd}) {
    const auto prepared = prepare(std::move(*mesh));
    ASSERT_FALSE(prepared.ok());
    EXPECT_EQ(prepared.error().code, ErrorCode::usage);
  }
}

}  // namespace
}  // namespace vcd::test
