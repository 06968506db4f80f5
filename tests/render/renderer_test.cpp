#include "render/renderer.h"

#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include <vcd/baker/measure.h>

#include "render/recording.h"
#include "render/sampling.h"
#include "worlds.h"

namespace vcd::test {
using namespace baker;
namespace {

MakeCaster bvh(const World& world, EmbreeQuery packets = {1}) {
  return [&world, packets] { return std::make_unique<BvhShadows>(world, packets); };
}
MakeCaster with_sidecars(const World& world, const WorldSidecars& sidecars, EmbreeQuery packets = {1}) {
  return [&world, &sidecars, packets] { return std::make_unique<SidecarShadows>(world, sidecars.objects, packets); };
}

TEST(Sampling, StrataTileTheSquareAndNeighboursLieTogether) {
  for (uint32_t count : {1u, 2u, 7u, 12u, 16u, 128u}) {
    const Strata strata = make_strata(count);
    ASSERT_EQ(strata.corners.size(), count);
    EXPECT_NEAR(strata.size.x * strata.size.y * static_cast<float>(count), 1, 1e-5);
    std::set<std::pair<long, long>> cells;
    for (const Sample2& corner : strata.corners)
      cells.insert({std::lround(corner.x / strata.size.x), std::lround(corner.y / strata.size.y)});
    EXPECT_EQ(cells.size(), count);
  }
  const Strata strata = make_strata(128);  // 16 × 8: the first sixteen are a block of 4 × 4
  for (size_t i = 0; i < 16; ++i) EXPECT_TRUE(strata.corners[i].x < 0.25f && strata.corners[i].y < 0.5f);
}

TEST(Renderer, GroundUnderALightIsAsBrightAsTheIntegralSays) {
  // A white ground, a square light above it, and an object far off the light's way.
  scenes::Scene scene = scenes::around(scene_mesh(triangle()));
  scene.instances[0].transform = {1, 0, 0, 30, 0, 1, 0, 0, 0, 0, 1, 30};
  scene.ground = {0, 0, 0, 50, {1, 1, 1}};
  scene.camera = {{0, 4, 6}, {0, 0, 0}, 1};
  scene.lights = {{{-1, 3, -1}, {2, 0, 0}, {0, 0, 2}, {5, 5, 5}}};
  const World world = must_build(std::move(scene));
  ASSERT_LT(world.lights[0].quad.normal.y, 0);
  RenderSettings settings = small_picture();
  settings.width = settings.height = 1, settings.pixel_samples = 16, settings.light_samples = 1024;
  double integral = 0;  // of cos · cos / (π r²) over the light, midpoint rule
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double x = -1 + 2 * (i + 0.5) / kSteps, z = -1 + 2 * (j + 0.5) / kSteps, squared = x * x + 9 + z * z;
      integral += 9 / (std::numbers::pi * squared * squared) * (4.0 / (kSteps * kSteps));
    }
  EXPECT_NEAR(must_render(world, settings, bvh(world)).image.pixels[0].x, 5 * integral, 0.005);
}

TEST(Renderer, SamePictureForAnyNumberOfThreads) {
  const World world = several_instances();
  const Rendered one = must_render(world, small_picture(1), bvh(world));
  for (unsigned threads : {2u, 5u}) {
    const Rendered many = must_render(world, small_picture(threads), bvh(world));
    EXPECT_TRUE(same_bits(one.image, many.image));
    EXPECT_EQ(one.shadow_segments, many.shadow_segments);
  }
}

TEST(Renderer, AnObjectOnItsSideLooksTheSame) {
  // The same leaves with their axes renamed, and told which way is up.
  const World upright = one_object('y');
  SourceMesh turned = leaves(300);
  for (Position& p : turned.positions) p = {p[0], -p[2], p[1]};  // z up: around() turns it back
  const World lying = must_build(scenes::around(scene_mesh(turned), 'z'));
  const Image a = must_render(upright, small_picture(), bvh(upright)).image,
              b = must_render(lying, small_picture(), bvh(lying)).image;
  EXPECT_LT(compare(a, b).rmse, 0.02);
}

TEST(Renderer, SelfShadowRaysAreCastOnlyWhereTheSurfaceFacesTheLight) {
  const World world = one_object();
  const Recording bundles = record(world, small_picture());
  ASSERT_GT(bundles.size(), 100u);
  uint64_t full = 0, of_light = 0;
  for (size_t i = 0; i < bundles.size(); ++i) {
    const Bundle bundle = bundles[i];
    full += bundle.segments.size() == 32, of_light += bundle.segments.size() < 32;
    for (const Segment& s : bundle.segments) {
      const Vec3 d{s.direction[0], s.direction[1], s.direction[2]};
      bool faces_a_light = false;
      for (const Light& light : world.lights) faces_a_light |= dot(d, light.quad.normal) < 0;
      EXPECT_TRUE(faces_a_light);
    }
  }
  EXPECT_GT(full, 0u);
  EXPECT_GT(of_light, 0u);  // some leaf faces part of a light only
}

TEST(Renderer, UnclassifiedCellsGiveTheBvhsPictureToTheLastBit) {
  const TemporaryFolder folder;
  for (const World& world : {one_object(), several_instances()}) {
    std::vector<BakedObject> unclassified;
    for (const WorldObject& object : world.objects) unclassified.push_back(make_unclassified_object(object.mesh, 4));
    ASSERT_TRUE(write_world(world, unclassified, folder / "world.vcd").ok());
    auto sidecars_or_error = open_sidecars(world, {(folder / "world.vcd").string()});
    ASSERT_TRUE(sidecars_or_error.ok());
    const WorldSidecars& sidecars = *sidecars_or_error;
    for (const EmbreeQuery& packets : world.ways_to_trace()) {
      const Image expected = must_render(world, small_picture(), bvh(world, packets)).image;
      EXPECT_TRUE(
          same_bits(expected, must_render(world, small_picture(), with_sidecars(world, sidecars, packets)).image))
          << name_of(packets);
    }
  }
}

TEST(Renderer, SidecarsChangeThePictureNoMoreThanTheirErrors) {
  const TemporaryFolder folder;
  for (const World& world : {one_object(), several_instances()}) {
    const WorldSidecars sidecars = must_bake(world, quick(4, 81), folder);
    const Difference difference = compare(must_render(world, small_picture(), bvh(world)).image,
                                          must_render(world, small_picture(), with_sidecars(world, sidecars)).image);
    EXPECT_LT(difference.rmse, 0.02);
  }
}

TEST(Renderer, CanBeStopped) {
  const World world = one_object();
  RenderHooks hooks;
  hooks.stop = [] { return true; };
  EXPECT_FALSE(render::render(world, small_picture(), bvh(world), hooks).ok());
}

TEST(Sidecars, ThoseOfAnotherMeshAreStale) {
  const TemporaryFolder folder;
  const World world = one_object(), other = several_instances();
  must_bake(other, quick(2), folder);
  const auto opened = open_sidecars(world, {(folder / "world.vcd").string()});
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::stale);
}

}  // namespace
}  // namespace vcd::test
