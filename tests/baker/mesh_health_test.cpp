#include <vcd/baker/mesh_health.h>

#include <functional>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include <vcd/baker/bake.h>

#include "classify/make_classifier.h"
#include "plan/blocked_proofs.h"
#include "support/files.h"
#include "support/hostile_meshes.h"

namespace vcd::test {
using namespace baker;
namespace {

MeshHealth health_of(const PreparedMesh& mesh) { return mesh_health(mesh.positions.size(), mesh.triangles); }
MeshHealth health_of(SourceMesh mesh) { return health_of(*prepare(std::move(mesh))); }

TEST(MeshHealth, OfAClosedMeshIsWhole) {
  for (const SourceMesh& mesh : {cube(), inverted(cube())}) {
    const MeshHealth health = health_of(mesh);
    EXPECT_TRUE(health.closed() && health.is_manifold());
    EXPECT_EQ(health.components, 1u);
    EXPECT_EQ(health.boundary_loops, 0u);
  }
}

SourceMesh without(SourceMesh mesh, const std::function<bool(size_t)>& is_gone) {
  std::vector<TriangleIndices> kept;
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    if (!is_gone(t)) kept.push_back(mesh.triangles[t]);
  mesh.triangles = std::move(kept);
  return mesh;
}

TEST(MeshHealth, CountsHolesAndPieces) {
  SourceMesh mesh = without(cube(), [](size_t t) { return t == 0; });
  append(mesh, without(cube(), [](size_t t) { return t == 1 || t == 2; }), 1, {9, 0, 0});
  const MeshHealth health = health_of(mesh);
  EXPECT_EQ(health.components, 2u);
  EXPECT_FALSE(health.closed());
  EXPECT_EQ(health.boundary_loops, 3u);
  EXPECT_EQ(health.boundary_edges.size(), 9u);
  EXPECT_TRUE(health.is_manifold());
}

TEST(MeshHealth, TellsEdgesOfThreeTrianglesFromPointsWherePiecesTouch) {
  const MeshHealth book = health_of(
      SourceMesh{"", 0, {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}});
  EXPECT_EQ(book.nonmanifold_edges.size(), 1u);
  EXPECT_TRUE(book.nonmanifold_vertices.empty());
  EXPECT_EQ(book.components, 1u);
  const MeshHealth hourglass =
      health_of(SourceMesh{"", 0, {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, -1}}, {{0, 1, 2}, {0, 3, 4}}});
  EXPECT_TRUE(hourglass.nonmanifold_edges.empty());
  EXPECT_EQ(hourglass.nonmanifold_vertices.size(), 1u);
  EXPECT_EQ(hourglass.components, 2u);
  EXPECT_EQ(hourglass.boundary_loops, 1u);  // they touch
}

TEST(MeshHealth, AgreesWithAPlainCountOnEveryMesh) {
  for (const PreparedMesh& mesh : hostile_meshes()) {
    std::map<MeshHealth::Edge, int> triangles_at;
    for (const TriangleIndices& t : mesh.triangles)
      for (size_t i = 0; i < 3; ++i) ++triangles_at[{std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3])}];
    std::vector<MeshHealth::Edge> boundary, nonmanifold;
    for (const auto& [edge, count] : triangles_at) {
      if (count == 1) boundary.push_back(edge);
      if (count > 2) nonmanifold.push_back(edge);
    }
    // A vertex's triangles, spread from the first one over edges at the vertex.
    std::vector<uint32_t> vertices;
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
      std::set<uint32_t> reached;
      size_t around = 0;
      for (const TriangleIndices& t : mesh.triangles) around += std::ranges::count(t, v) > 0;
      for (bool more = true; more;) {
        more = false;
        size_t met = 0;
        for (const TriangleIndices& t : mesh.triangles) {
          if (std::ranges::count(t, v) == 0) continue;
          const bool joins = std::ranges::any_of(t, [&](uint32_t w) { return w != v && reached.contains(w); });
          met += joins || reached.empty();
          if (!joins && !reached.empty()) continue;
          for (const uint32_t w : t)
            if (w != v) more |= reached.insert(w).second;
        }
        if (!more && met < around) vertices.push_back(v);
      }
    }
    const MeshHealth health = health_of(mesh);
    EXPECT_EQ(health.boundary_edges, boundary) << mesh.name;
    EXPECT_EQ(health.nonmanifold_edges, nonmanifold) << mesh.name;
    EXPECT_EQ(health.nonmanifold_vertices, vertices) << mesh.name;
  }
}

BlockedProofs proofs_of(SourceMesh source) {
  const PreparedMesh mesh = *prepare(std::move(source));
  const GridMesh grid(mesh);
  const auto tracer = trace_in_grid(grid);
  return count_blocked_proofs(ProvenClassifier(grid, *tracer, {}), mesh, health_of(mesh), 5);
}
// Without a hole at its poles.
SourceMesh watertight_sphere() { return on_grid(sphere(12, 24), 0x1p-8f); }

TEST(BlockedProofs, FailAtBoundariesOnlyWhereThereAreAny) {
  const BlockedProofs whole = proofs_of(watertight_sphere());
  EXPECT_GT(whole.look_blocked, 500u);
  EXPECT_GT(whole.proven, whole.look_blocked / 2);
  EXPECT_EQ(whole.at_boundary + whole.at_nonmanifold, 0u);

  const BlockedProofs torn = proofs_of(without(watertight_sphere(), [](size_t t) { return t % 7 == 0; }));
  EXPECT_GT(torn.at_boundary, torn.look_blocked / 20);
  EXPECT_EQ(torn.at_nonmanifold, 0u);
  EXPECT_LT(torn.proven * whole.look_blocked, whole.proven * torn.look_blocked);
  EXPECT_LE(torn.proven + torn.at_boundary, torn.look_blocked);
}

TEST(BlockedProofs, FailAtEdgesOfThreeTriangles) {
  SourceMesh mesh = watertight_sphere();
  for (size_t t = 0, count = mesh.triangles.size(); t < count; ++t) {  // a fin inwards at one edge of each
    Position tip{};
    for (const uint32_t corner : mesh.triangles[t])
      for (size_t a = 0; a < 3; ++a) tip[a] += mesh.positions[corner][a] / 10;
    mesh.positions.push_back(tip);
    mesh.triangles.push_back(
        {mesh.triangles[t][0], mesh.triangles[t][1], static_cast<uint32_t>(mesh.positions.size() - 1)});
  }
  EXPECT_GT(proofs_of(mesh).at_nonmanifold, 0u);
}

TEST(BlockedProofs, AreCountedOfMethodsThatProve) {
  BakeOptions options = proven(0);
  options.method = Method::sampled;
  EXPECT_FALSE(plan(*prepare(cube()), options)->proofs);
  const Plan planned = *plan(*prepare(cube()), proven(0));
  EXPECT_GT(planned.proofs->proven, 0u);
  EXPECT_EQ(planned.health.components, 1u);
}

}  // namespace
}  // namespace vcd::test
