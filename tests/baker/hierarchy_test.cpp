// The hierarchy that the baker builds: its triangles, its boxes, the same bytes always, and meshes that are hard to
// divide.
#include <vcd/baker/hierarchy.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <vcd/baker/bake.h>
#include <vcd/baker/threads.h>
#include <vcd/format/contents.h>

#include "hierarchy/binary_tree.h"
#include "hierarchy/blocking_order.h"
#include "hierarchy/collapse.h"
#include "hierarchy/reinsert.h"
#include "hierarchy/wide_tree.h"
#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
using namespace baker;
namespace {

using Corners = std::array<Position, 3>;  // ascending

Corners ascending(Corners t) {
  std::ranges::sort(t);
  return t;
}

void add_triangles(const HierarchyView& hierarchy, uint32_t unit, std::vector<Corners>& triangles) {
  for (const uint32_t child : hierarchy.node(unit).child) {
    if (child == kNoChild) return;
    if (!(child & kLeafChild)) {
      add_triangles(hierarchy, child, triangles);
      continue;
    }
    with_leaf(hierarchy, child, [&](const auto& leaf) {
      for (int t = 0; t < std::popcount(leaf.present); ++t) {
        Corners corners;
        for (size_t c = 0; c < 3; ++c)
          for (size_t a = 0; a < 3; ++a) corners[c][a] = leaf.vertex[a][leaf.corner[c][t]];
        triangles.push_back(ascending(corners));
      }
    });
  }
}

std::vector<Corners> triangles_of(const HierarchyView& hierarchy) {
  std::vector<Corners> triangles;
  add_triangles(hierarchy, kRootUnit, triangles);
  std::ranges::sort(triangles);
  return triangles;
}

std::vector<Corners> triangles_of(const PreparedMesh& mesh) {
  std::vector<Corners> triangles;
  for (const TriangleIndices& t : mesh.triangles)
    triangles.push_back(ascending({mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]}));
  std::ranges::sort(triangles);
  return triangles;
}

bool equal(const HierarchySection& a, const HierarchySection& b) {
  return std::ranges::equal(bytes_of(a), bytes_of(b));
}

// Builds the mesh's hierarchy, and looks at all that the format and the mesh demand of it.
HierarchySection must_build(const PreparedMesh& mesh) {
  EXPECT_TRUE(can_have_hierarchy(mesh));
  const auto section = with_threads(0, [&] { return build_hierarchy(mesh); });
  if (!section || section->empty()) throw std::runtime_error("no hierarchy");
  const auto fault = check_hierarchy(bytes_of(*section), CheckLevel::canonical);
  EXPECT_FALSE(fault) << static_cast<int>(fault->kind) << " at unit " << fault->unit;
  EXPECT_EQ(triangles_of(view_of(*section)), triangles_of(mesh));
  return *section;
}
HierarchySection must_build(SourceMesh source) { return must_build(*prepare(std::move(source))); }

double bytes_a_triangle(const HierarchySection& section) {
  return static_cast<double>(bytes_of(section).size()) / static_cast<double>(view_of(section).header().triangle_count);
}

TEST(Hierarchy, HoldsEveryTriangleOnceAndItsBoxesExactly) {
  EXPECT_LE(bytes_a_triangle(must_build(sphere(60, 120))), 29);
  EXPECT_LE(bytes_a_triangle(must_build(leaves(3000))), 68);  // which share no vertices
  must_build(cube());
}

TEST(Hierarchy, OfOneTriangleIsARootWithOneLeaf) {
  const HierarchySection section = must_build(triangle());
  const HierarchyHeader& header = view_of(section).header();
  EXPECT_EQ(header.node_count, 1u);
  EXPECT_EQ(header.leaf_count, 1u);
  EXPECT_EQ(header.levels, 1u);
  EXPECT_EQ(section.size(), 1u + 7 + 4);
}

TEST(Hierarchy, IsTheSameOnAnyNumberOfThreads) {
  const PreparedMesh mesh = *prepare(sphere(200, 400));  // large enough for what threads do together
  ASSERT_GT(mesh.triangles.size(), 1u << 17);
  const auto build = [&](unsigned threads) { return with_threads(threads, [&] { return *build_hierarchy(mesh); }); };
  const HierarchySection one = build(1);
  for (unsigned threads : kSanitized ? std::vector{3u} : std::vector{2u, 3u, 8u})
    EXPECT_TRUE(equal(build(threads), one)) << threads;
}

TEST(Hierarchy, DoesNotDependOnTheOrderOfTheInput) {
  const SourceMesh mesh = sphere();
  SourceMesh other = mesh;
  std::mt19937 random(1);
  std::vector<uint32_t> order(mesh.positions.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::shuffle(order, random);
  for (uint32_t i = 0; i < order.size(); ++i) other.positions[order[i]] = mesh.positions[i];
  for (TriangleIndices& t : other.triangles) t = {order[t[1]], order[t[2]], order[t[0]]};
  std::ranges::shuffle(other.triangles, random);
  EXPECT_TRUE(equal(must_build(std::move(other)), must_build(SourceMesh(mesh))));
}

// Four thousand triangles around one point: no plane divides their centroids.
TEST(Hierarchy, DividesCoincidentCentroids) {
  SourceMesh mesh{"star", 0, {}, {}};
  std::mt19937 random(7);
  const auto whole = [&] { return static_cast<float>(static_cast<int>(random() % 4001) - 2000); };
  for (uint32_t i = 0; i < (kSanitized ? 1000 : 4000); ++i) {
    // The box of a and -a has its middle at the origin, and b lies within it.
    const Position a = {whole(), whole(), 2001};
    mesh.positions.insert(mesh.positions.end(), {a, {-a[0], -a[1], -a[2]}, {a[0] / 2, a[1] / 4, a[2] / 8}});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const HierarchySection section = must_build(std::move(mesh));
  EXPECT_LE(view_of(section).header().levels, 16u);
}

SourceMesh slivers() {
  SourceMesh mesh{"slivers", 0, {}, {}};
  std::mt19937 random(3);
  for (uint32_t i = 0; i < 4000; ++i) {
    const auto y = static_cast<float>(random() % 1000), z = static_cast<float>(random() % 1000);
    mesh.positions.insert(mesh.positions.end(), {{-1000, y, z}, {1000, y, z}, {0, y + 1e-3f, z}});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

TEST(Hierarchy, TakesSliversAndFans) {
  SourceMesh fan{"fan", 0, {{0, 0, 0}}, {}};
  for (uint32_t i = 0; i <= 5000; ++i) {
    const double angle = i * 1e-3;
    fan.positions.push_back({static_cast<float>(1000 * std::cos(angle)), static_cast<float>(1000 * std::sin(angle)),
                             static_cast<float>(i % 3)});
    if (i > 0) fan.triangles.push_back({0, i, i + 1});
  }
  must_build(std::move(fan));
  must_build(slivers());
}

// Heaps of triangles, each so much smaller and nearer to the origin than the one before that the heuristic cuts off one
// after the other; the last one can only be halved, 13 times. (Areas of the small ones are 0 in floats.)
SourceMesh heaps(int exponent) {
  SourceMesh mesh{"heaps", 0, {}, {}};
  for (; exponent > -120; exponent -= exponent > -72 ? 3 : 4) {
    const float x = std::ldexp(1.0f, exponent);
    for (uint32_t k = 0; k < (exponent <= -116 ? 8192 : 400); ++k) {
      // All of a heap have one box.
      const auto first = static_cast<uint32_t>(mesh.positions.size());
      const float y = x * (1 + static_cast<float>(k % 64) / 64), z = x * (1 + static_cast<float>(k / 64) / 128);
      mesh.positions.insert(mesh.positions.end(), {{x, x, x}, {2 * x, 2 * x, 2 * x}, {x, y, z + x / 256}});
      mesh.triangles.push_back({first, first + 1, first + 2});
    }
  }
  return mesh;
}

TEST(Hierarchy, StaysWithinTheLevelsOnAnyScale) {
  const std::function<bool()> no_stop;
  Stop never(no_stop);
  const BinaryTree tree = with_threads(0, [&] { return build_binary_tree(*prepare(heaps(50)), never); });
  std::vector<uint32_t> depth(tree.nodes.size());
  for (uint32_t i = 0; i < tree.nodes.size(); ++i)
    if (!tree.is_leaf(i)) depth[tree.left(i)] = depth[tree.right(i)] = depth[i] + 1;
  EXPECT_EQ(*std::ranges::max_element(depth), kMostLevels) << "more: too deep; fewer: the mesh is too easy";
  must_build(heaps(38));
}

// Looks at all that BinaryTree says of itself. Returns the sum of its boxes' areas.
double check(const BinaryTree& tree, const PreparedMesh& mesh) {
  double sum = 0;
  std::vector<uint32_t> depth(tree.nodes.size()), triangles = tree.triangles;
  for (uint32_t i = 0; i < tree.nodes.size(); ++i) {
    const BinaryNode& node = tree.nodes[i];
    sum += Box::of(node.box).half_area();
    Bounds box;
    if (tree.is_leaf(i)) {
      for (const uint32_t corner : mesh.triangles[tree.triangles[node.first]]) box.add(mesh.positions[corner]);
    } else {
      const BinaryNode &left = tree.nodes[tree.left(i)], &right = tree.nodes[tree.right(i)];
      box = together(Box::of(left.box), Box::of(right.box)).bounds();
      EXPECT_EQ(left.first, node.first);
      EXPECT_EQ(right.first, node.first + left.count);
      EXPECT_EQ(left.count + right.count, node.count);
      depth[tree.left(i)] = depth[tree.right(i)] = depth[i] + 1;
    }
    EXPECT_TRUE(box.min == node.box.min && box.max == node.box.max) << i;
  }
  EXPECT_LE(*std::ranges::max_element(depth), kMostLevels);
  std::ranges::sort(triangles);
  for (uint32_t t = 0; t < triangles.size(); ++t) EXPECT_EQ(triangles[t], t);
  return sum;
}

TEST(Hierarchy, SubtreesGoWhereBoxesBecomeSmaller) {
  const std::function<bool()> no_stop;
  Stop never(no_stop);
  struct {
    SourceMesh mesh;
    double most;  // of the areas before
  } cases[] = {{leaves(3000), 0.98}, {slivers(), 0.985}, {sphere(60, 120), 0.995}, {heaps(50), 1}, {triangle(), 1}};
  for (auto& one : cases) {
    const PreparedMesh mesh = *prepare(std::move(one.mesh));
    with_threads(0, [&] {
      BinaryTree tree = build_binary_tree(mesh, never);
      const double before = check(tree, mesh);
      reinsert(tree, never);
      const double after = check(tree, mesh);
      EXPECT_LE(after, one.most * before) << mesh.name;
      return 0;
    });
  }
}

TEST(Hierarchy, IsOfMeshesWithinTheLimitsOnly) {
  const auto scaled = [](float scale) {
    SourceMesh mesh = sphere(6, 8);
    for (Position& p : mesh.positions)
      for (float& x : p) x *= scale;
    return *prepare(std::move(mesh));
  };
  for (const float scale : {kLeastHierarchyCoordinate, kMostHierarchyCoordinate}) must_build(scaled(scale));
  EXPECT_FALSE(can_have_hierarchy(scaled(kLeastHierarchyCoordinate / 2)));
  EXPECT_FALSE(can_have_hierarchy(scaled(kMostHierarchyCoordinate * 2)));
}

TEST(Hierarchy, EndsEarlyWhenItIsStopped) {
  const PreparedMesh mesh = *prepare(sphere(60, 120));
  for (int after : {0, 1, 5, 50}) {
    std::atomic<int> asked = 0;
    EXPECT_FALSE(build_hierarchy(mesh, [&] { return asked++ >= after; })) << after;
  }
}

// A wall of many triangles, and dust behind it that hardly ever blocks.
TEST(Hierarchy, PutsWhatBlocksFirst) {
  SourceMesh mesh = leaves(0);
  std::mt19937 random(5);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  const auto add = [&](Position p, float size) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {p, {p[0] + size, p[1], p[2]}, {p[0], p[1] + size, p[2] + size / 4}});
    mesh.triangles.push_back({first, first + 1, first + 2});
  };
  for (int i = 0; i < 400; ++i) add({uniform(), uniform(), 0.01f * uniform()}, 0.002f);
  for (int i = 0; i < 400; ++i) add({uniform(), uniform(), 1 + 0.01f * uniform()}, 0.2f);
  const PreparedMesh prepared = *prepare(std::move(mesh));
  const HierarchySection section = must_build(prepared);
  const HierarchyNode& root = view_of(section).node(kRootUnit);
  EXPECT_GT(root.max[2][0], 0.5f) << "dust comes first";
}

TEST(Hierarchy, IsWrittenAndReadInEitherStorage) {
  const PreparedMesh mesh = *prepare(sphere());
  const HierarchySection section = must_build(mesh);
  for (const Method method : {Method::sampled, Method::none}) {
    BakeOptions options = quick(2);
    options.method = method;
    for (const bool asked : {true, false}) {
      options.hierarchy = asked;
      const auto baked = bake(mesh, options);
      ASSERT_TRUE(baked.ok());
      EXPECT_EQ(baked->without_hierarchy, "");
      for (const Storage storage : {Storage::raw, Storage::zstd}) {
        const auto bytes = sidecar_bytes({&*baked}, storage);
        std::vector<Finding> findings;
        const auto contents = read_sidecar(bytes, CheckLevel::canonical, findings);
        ASSERT_TRUE(contents.has_value()) << describe(findings[0]);
        EXPECT_TRUE(std::ranges::equal(contents->objects[0].hierarchy.bytes(), asked ? bytes_of(section) : Bytes()));
      }
    }
  }
}

TEST(Hierarchy, TakesItsBytesOfTheBudgetOrIsLeftOut) {
  const PreparedMesh mesh = *prepare(sphere());
  const uint64_t bytes = bytes_of(must_build(mesh)).size();
  BakeOptions options = proven(4);
  const uint64_t whole = sidecar_bytes({&*bake(mesh, options)}).size();
  options.budget_bytes = whole - 4096;
  const auto smaller = bake(mesh, options);
  ASSERT_TRUE(smaller.ok());
  EXPECT_EQ(smaller->without_hierarchy, "");
  EXPECT_FALSE(smaller->to_write().hierarchy.empty());
  EXPECT_GT(smaller->cells_demoted, 0u);
  EXPECT_LE(sidecar_bytes({&*smaller}).size(), options.budget_bytes);
  options.budget_bytes = 2 * bytes - 1;
  const auto without = bake(mesh, options);
  ASSERT_TRUE(without.ok());
  EXPECT_NE(without->without_hierarchy, "");
  EXPECT_TRUE(without->to_write().hierarchy.empty());
}

// A look-up answers most lines through a sphere, some through a few leaves, and hardly any through many whose cells are
// coarse.
TEST(Hierarchy, SaysWhereLookUpsBeforeItPay) {
  if (kSanitized) GTEST_SKIP() << kOnceIsEnough;
  const auto flags_of = [](const SourceMesh& source, bool with_hierarchy) {
    BakeOptions options = proven(with_hierarchy ? 3 : 2);
    options.hierarchy = with_hierarchy;
    return must_bake(source, options).record.flags;
  };
  constexpr uint16_t kBoth = kLookUpFromOutside | kLookUpTogetherFromOutside;
  EXPECT_EQ(flags_of(sphere(60, 120), true) & (kBoth | kLookUpOneFromOutside), kBoth);
  // Segments from inside its box that begin beside it save as much as those from outside.
  constexpr uint16_t kOnes = kLookUpOneFromOutside | kLookUpOneFromInside;
  EXPECT_EQ(flags_of(sphere(4, 4000), true) & (kBoth | kOnes), kBoth | kOnes);
  EXPECT_EQ(flags_of(leaves(20), true), kLookUpFromOutside | kLookUpFromInside);
  EXPECT_EQ(flags_of(leaves(40), true), 0);
  EXPECT_EQ(flags_of(sphere(), false), 0);
}

}  // namespace
}  // namespace vcd::test
