// The boxes that hold an instance in the world, and the scene's nodes over them.
#include "scene/placement.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <vcd/baker/hierarchy.h>
#include <vcd/baker/prepare.h>

#include "scene/build_hierarchy.h"
#include "scene/walk.h"
#include "support/exact_world.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/random.h"

namespace vcd::test {
namespace {

double area(const Placed& placed) {
  const double x = double{placed.high[0]} - placed.low[0], y = double{placed.high[1]} - placed.low[1],
               z = double{placed.high[2]} - placed.low[2];
  return x * y + y * z + z * x;
}

// Every vertex keeps 2^-11 of the object's extents away from the box in the world, as proofs of scenes ask.
void expect_room(const baker::SourceMesh& mesh, const SceneInstance& instance, const Transform& to_world,
                 const Placed& placed) {
  for (const baker::Position& p : mesh.positions)
    for (size_t i = 0; i < 3; ++i) {
      double x = to_world.rows[i][3], room = 0;
      for (size_t j = 0; j < 3; ++j) {
        x += double{to_world.rows[i][j]} * p[j];
        room += std::abs(to_world.rows[i][j]) * 0x1p-11 * (double{instance.box_max[j]} - instance.box_min[j]);
      }
      ASSERT_LE(placed.low[i], x - room);
      ASSERT_GE(placed.high[i], x + room);
    }
}

TEST(Placement, HoldsTheMeshWithRoomAndFitsItHoweverItIsTurned) {
  FloatRandom random(3);
  for (const baker::SourceMesh& mesh : {sphere(40, 80), leaves(2000), cube()}) {
    const baker::BakedObject baked = must_bake(mesh, proven(1));
    const auto section = baker::build_hierarchy(*baker::prepare(baker::SourceMesh(mesh)));
    const MeshBoxes boxes = mesh_boxes(baked.record, traced(baker::view_of(*section)));
    SceneInstance instance{};
    std::copy_n(baked.record.box_min, 3, instance.box_min), std::copy_n(baked.record.box_max, 3, instance.box_max);
    double tight = 0, loose = 0;
    for (int k = 0; k < 200; ++k) {
      Transform turned;
      for (auto& row : turned.rows)
        for (float& x : row) x = random.between(-1, 1) * (k % 4 == 0 ? 1000.0f : 1.0f);
      const Placed placed = place(instance, &boxes, turned), by_box = place(instance, nullptr, turned);
      expect_room(mesh, instance, turned, placed);
      expect_room(mesh, instance, turned, by_box);
      for (int a = 0; a < 3; ++a) {
        const float slack = (by_box.high[a] - by_box.low[a]) * 0x1p-20f;
        EXPECT_GE(placed.low[a], by_box.low[a] - slack);
        EXPECT_LE(placed.high[a], by_box.high[a] + slack);
      }
      tight += std::sqrt(area(placed)), loose += std::sqrt(area(by_box));
    }
    EXPECT_LT(tight, loose * (mesh.name == "sphere" ? 0.8 : 1.0 + 1e-6)) << mesh.name << " " << tight / loose;
  }
}

// One instance of a mesh, as it stands.
struct Alone {
  SceneInstance instance{};
  MeshBoxes boxes;
  Placed placed;
  SceneData scene;

  explicit Alone(const baker::SourceMesh& mesh) {
    const baker::BakedObject baked = must_bake(mesh, proven(1));
    const auto section = baker::build_hierarchy(*baker::prepare(baker::SourceMesh(mesh)));
    boxes = mesh_boxes(baked.record, traced(baker::view_of(*section)));
    std::copy_n(baked.record.box_min, 3, instance.box_min), std::copy_n(baked.record.box_max, 3, instance.box_max);
    placed = place(instance, &boxes, kStill);
    scene.nodes =
        build_hierarchy(std::span(&placed, 1), [&](uint32_t) { return boxes_in_world(placed, boxes, kStill); });
    scene.instances.resize(1);
    scene.instances[0].mask = ~0u;
  }
  // As often as a segment comes to it.
  int visits(const Segment& segment) const {
    int visits = 0;
    const SceneRay ray = scene_ray(segment);
    walk(
        scene, ~0u, [&](const SceneNode& node) { return boxes_met(node, ray); }, [] { return false; },
        [&](uint32_t) { ++visits; });
    return visits;
  }
};

// As in a damaged file that was only checked for bounds.
TEST(Placement, StandsEverywhereWhereBoxesAreNoNumbers) {
  const baker::SourceMesh mesh = sphere(40, 80);
  const baker::BakedObject baked = must_bake(mesh, proven(1));
  SceneInstance instance{};
  std::copy_n(baked.record.box_min, 3, instance.box_min), std::copy_n(baked.record.box_max, 3, instance.box_max);
  const Transform turned{{{1, 2, 3, 4}, {-2, 1, 0, 5}, {0, 3, -1, 6}}};
  const auto no_number = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  for (const float bad : {no_number, infinity, -infinity}) {
    auto section = *baker::build_hierarchy(*baker::prepare(baker::SourceMesh(mesh)));
    const auto spoil = [&](uint32_t unit) {
      auto& node = *reinterpret_cast<HierarchyNode*>(section[unit].bytes);
      for (size_t a = 0; a < 3; ++a) std::ranges::fill(node.min[a], bad), std::ranges::fill(node.max[a], bad);
      return node;
    };
    for (const uint32_t child : spoil(kRootUnit).child)
      if (!(child & kLeafChild)) spoil(child);
    const MeshBoxes boxes = mesh_boxes(baked.record, traced(baker::view_of(section)));
    const Placed placed = place(instance, &boxes, turned);
    for (int a = 0; a < 3; ++a) {
      EXPECT_EQ(placed.middle[a], 0);
      EXPECT_EQ(placed.low[a], -infinity);
      EXPECT_EQ(placed.high[a], infinity);
    }
  }
}

TEST(SceneNodes, EncloseASparseInstanceBySeveralBoxesAndVisitItOnce) {
  baker::SourceMesh pair = sphere(20, 40);
  const baker::SourceMesh one = pair;
  const auto first = static_cast<uint32_t>(one.positions.size());
  for (const baker::Position& p : one.positions) pair.positions.push_back({p[0] + 10, p[1] + 10, p[2] + 10});
  for (const auto& t : one.triangles) pair.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  const Alone sparse(pair), dense(sphere(20, 40));

  ASSERT_EQ(sparse.scene.nodes.size(), 1u);
  const SceneNode& node = sparse.scene.nodes[0];
  size_t boxes = 1;
  while (node.child[boxes - 1] & kAgain) ++boxes;
  EXPECT_GT(boxes, 2u);
  EXPECT_FALSE(dense.scene.nodes[0].child[0] & kAgain);  // parts of a sphere are not smaller together
  for (const baker::Position& p : pair.positions) {
    const auto holds = [&](size_t k) {
      for (size_t a = 0; a < 3; ++a) {
        const float room = 0x1p-11f * (sparse.instance.box_max[a] - sparse.instance.box_min[a]);
        if (!(node.side[0][a][k] <= p[a] - room && p[a] + room <= node.side[1][a][k])) return false;
      }
      return true;
    };
    bool held = false;
    for (size_t k = 0; k < boxes; ++k) held |= holds(k);
    EXPECT_TRUE(held);
  }
  EXPECT_EQ(sparse.visits({{-5, -5, -5}, 0, {30, 30, 30}, 1}), 1);    // through both
  EXPECT_EQ(sparse.visits({{-5, 5, 5}, 0, {30, 0.1f, 0.1f}, 1}), 0);  // between them, through the box of both
}

}  // namespace
}  // namespace vcd::test
