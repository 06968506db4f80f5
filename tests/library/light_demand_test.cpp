#include <vcd/library/light_demand.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "support/meshes.h"

namespace vcd::library {
namespace {

using namespace baker;

constexpr size_t kFew = 4000;

PreparedMesh cube() { return *prepare(test::cube()); }

SceneLight point_at(double x, double y, double z) {
  SceneLight light;
  light.position = {x, y, z};
  return light;
}

std::array<double, 12> moved(double x, double y, double z) { return {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}; }

TEST(LightDemand, SegmentsRunFromTheGroundOfAShadowToTheLight) {
  const PreparedMesh mesh = cube();
  const LitInstance instance{&mesh};
  const SceneLight light = point_at(0.5, 3, 0.5);
  const auto demand = demand_of_lights(std::span(&instance, 1), std::span(&light, 1), Axis::y, kFew);
  ASSERT_TRUE(demand.ok());
  const auto& asked = demand->at(mesh.geometry_hash);
  EXPECT_GT(asked.size(), kFew / 2);
  EXPECT_LE(asked.size(), kFew);
  for (const auto& [s, weight] : asked) {
    EXPECT_NEAR(s.origin[1], 0, 1e-6);
    for (int a : {0, 2}) EXPECT_NEAR(s.origin[a], 0.5, 0.7501) << "the top's shadow is 1.5 wide";
    EXPECT_NEAR(s.origin[0] + s.direction[0], 0.5, 1e-6);
    EXPECT_NEAR(s.origin[1] + s.direction[1], 3, 1e-6);
  }
}

TEST(LightDemand, SurfacesAskOtherInstancesInTheirOwnFrame) {
  const PreparedMesh mesh = cube();
  const LitInstance instances[] = {{&mesh, moved(0, 0, 0)}, {&mesh, moved(0, 5, 0)}};
  SceneLight sun;
  sun.shape = SceneLight::Shape::directional, sun.direction = {0, -1, 0};
  const auto demand = demand_of_lights(instances, std::span(&sun, 1), Axis::y, kFew);
  ASSERT_TRUE(demand.ok());
  size_t below = 0;
  for (const auto& [s, weight] : demand->at(mesh.geometry_hash)) {
    EXPECT_TRUE(std::isinf(s.t_max));
    EXPECT_EQ(s.direction[1], 1);
    below += s.origin[1] < -3.9f;  // from the lower cube, as the upper one sees it
  }
  EXPECT_GT(below, 100u);
}

TEST(LightDemand, LightsThatReachNothingAskNothing) {
  const PreparedMesh mesh = cube();
  const LitInstance instance{&mesh};
  SceneLight spot = point_at(0.5, 3, 0.5), near = spot, rectangle = spot;
  spot.direction = {0, 1, 0}, spot.cone_cosine = 0.5;  // it shines away
  near.range = 0.5;
  rectangle.shape = SceneLight::Shape::rectangle, rectangle.direction = {0, 1, 0};
  for (const SceneLight& light : {spot, near, rectangle}) {
    const auto demand = demand_of_lights(std::span(&instance, 1), std::span(&light, 1), Axis::y, 100);
    ASSERT_TRUE(demand.ok());
    EXPECT_TRUE(demand->empty());
  }
  EXPECT_TRUE(demand_of_lights({}, std::span(&spot, 1))->empty());
  EXPECT_TRUE(demand_of_lights(std::span(&instance, 1), {})->empty());
}

TEST(LightDemand, TheSkyIsAskedFromTheGroundAlongEachAxis) {
  const PreparedMesh mesh = cube();
  for (const Axis up : {Axis::x, Axis::y, Axis::z}) {
    const auto demand = demand_from_above(mesh, up, kFew), again = demand_from_above(mesh, up, kFew);
    ASSERT_TRUE(demand.ok() && again.ok());
    const auto& once = demand->at(mesh.geometry_hash);
    const auto& twice = again->at(mesh.geometry_hash);
    ASSERT_EQ(once.size(), twice.size());
    EXPECT_EQ(std::memcmp(once.data(), twice.data(), once.size() * sizeof once[0]), 0);
    for (const auto& [s, weight] : demand->at(mesh.geometry_hash)) {
      EXPECT_NEAR(s.origin[static_cast<size_t>(up)], 0, 1e-6);
      EXPECT_GT(s.direction[static_cast<size_t>(up)], 0);
      EXPECT_TRUE(std::isinf(s.t_max));
    }
  }
}

}  // namespace
}  // namespace vcd::library
