// The shadow rays of paths: where they begin and end, and that they are the same again.
#include "render/path_rays.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "render/shadows.h"
#include "worlds.h"

namespace vcd::test {
namespace {

Vec3 at(const Segment& s, float t) {
  return Vec3{s.origin[0], s.origin[1], s.origin[2]} + Vec3{s.direction[0], s.direction[1], s.direction[2]} * t;
}

bool on(const Quad& quad, Vec3 p) {
  const Vec3 d = p - quad.corner;
  const float u = dot(d, quad.edge_u) / dot(quad.edge_u, quad.edge_u);
  const float v = dot(d, quad.edge_v) / dot(quad.edge_v, quad.edge_v);
  constexpr float kRoom = 1e-4f;
  return std::fabs(dot(d, quad.normal)) < kRoom * length(quad.edge_u) && u > -kRoom && u < 1 + kRoom && v > -kRoom &&
         v < 1 + kRoom;
}

TEST(PathRays, GoFromSurfacesToLightsAndToTheSky) {
  for (const World& world : {one_object(), several_instances()}) {
    uint64_t to_lights = 0, to_sky = 0, from_ground = 0, from_objects = 0;
    std::set<uint32_t> bounces;
    const PathRay* before = nullptr;
    const std::vector<PathRay> rays = trace_paths(world, {2000, 4, 1});
    for (const PathRay& ray : rays) {
      const Segment& s = ray.segment;
      bounces.insert(ray.bounce);
      EXPECT_EQ(s.t_min, 0);
      EXPECT_EQ(ray.from, from_of(world, ray.surface, s));
      if (std::isinf(s.t_max)) {
        ++to_sky;
        EXPECT_NEAR(length(at(s, 1) - at(s, 0)), 1, 1e-5);
        EXPECT_GT(dot(at(s, 1) - at(s, 0), world.ground.normal), 0);
      } else {
        ++to_lights;
        EXPECT_TRUE(std::any_of(world.lights.begin(), world.lights.end(),
                                [&](const Light& light) { return on(light.quad, at(s, s.t_max)); }));
      }
      if (ray.surface == kGroundSurface) {
        ++from_ground;
        EXPECT_NEAR(dot(at(s, 0) - world.ground.corner, world.ground.normal), world.shadow_offset,
                    0.1f * world.shadow_offset);
      } else {
        ++from_objects;
        EXPECT_LT(ray.surface, world.instances.size());
      }
      if (before) {
        EXPECT_TRUE(before->path < ray.path || (before->path == ray.path && before->bounce < ray.bounce));
      }
      before = &ray;
    }
    EXPECT_EQ(bounces, (std::set<uint32_t>{1, 2, 3, 4}));
    for (const uint64_t some : {to_lights, to_sky, from_ground, from_objects}) EXPECT_GT(some, rays.size() / 20);
  }
}

TEST(PathRays, AreTheSameAgainAndOthersWithAnotherSeed) {
  const World world = one_object();
  const auto segments = [&](uint64_t seed) {
    std::vector<float> values;
    for (const PathRay& ray : trace_paths(world, {400, 4, seed}))
      values.insert(values.end(), {ray.segment.origin[0], ray.segment.direction[0], ray.segment.t_max});
    return values;
  };
  EXPECT_EQ(segments(1), segments(1));
  EXPECT_NE(segments(1), segments(2));
}

TEST(PathRays, CarryLightThatEachSurfaceHasColoured) {
  World white = several_instances(), half = several_instances();
  for (auto [world, colour] : {std::pair(&white, 1.0f), std::pair(&half, 0.5f)}) {
    world->ground_colour = Vec3{colour, colour, colour};
    for (WorldObject& object : world->objects) object.colour = world->ground_colour;
  }
  const std::vector<PathRay> rays = trace_paths(white, {400, 4, 1}), darker = trace_paths(half, {400, 4, 1});
  ASSERT_EQ(rays.size(), darker.size());
  for (size_t i = 0; i < rays.size(); ++i) {
    EXPECT_GT(rays[i].light.x, 0);
    EXPECT_EQ(darker[i].light.x, std::ldexp(rays[i].light.x, -static_cast<int>(rays[i].bounce)));
  }
}

TEST(PathRays, OfFewerBouncesAreTheFirstOfEachPath) {
  const World world = one_object();
  for (const PathRay& ray : trace_paths(world, {400, 1, 1})) EXPECT_EQ(ray.bounce, 1u);
  EXPECT_LT(trace_paths(world, {400, 1, 1}).size(), trace_paths(world, {400, 2, 1}).size());
}

}  // namespace
}  // namespace vcd::test
