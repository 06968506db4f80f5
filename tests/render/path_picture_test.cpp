// Pictures by path tracing: their light, and that whoever answers the shadow rays the picture is the same.
#include "render/path_picture.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "worlds.h"

namespace vcd::test {
namespace {

RenderSettings picture(uint32_t paths, unsigned threads = 1) {
  RenderSettings settings = small_picture(threads);
  settings.pixel_samples = paths;
  return settings;
}

Image must_trace(const World& world, const RenderSettings& settings, const PathPicture& paths,
                 const MakePathCaster& make) {
  auto rendered = render_paths(world, settings, paths, make);
  if (!rendered) throw std::runtime_error(rendered.error().message);
  EXPECT_GT(rendered->shadow_segments, 0u);
  return std::move(rendered->image);
}

Vec3 mean(const Image& image) {
  double sum[3] = {};
  for (const Vec3& pixel : image.pixels) sum[0] += pixel.x, sum[1] += pixel.y, sum[2] += pixel.z;
  const auto count = static_cast<double>(image.pixels.size());
  return {static_cast<float>(sum[0] / count), static_cast<float>(sum[1] / count), static_cast<float>(sum[2] / count)};
}

// The sky is dark, or nothing stands before it and the lights are off.
class OnlyLights : public PathCaster {
 public:
  explicit OnlyLights(const World& world) : bvh_(world, {1}) {}
  void cast(const AskedRays& rays, std::span<uint8_t> blocked) override {
    bvh_.cast(rays, blocked);
    for (size_t i = 0; i < blocked.size(); ++i) blocked[i] |= std::isinf(rays.segments[i].t_max);
  }

 private:
  BvhPaths bvh_;
};
class OnlySky : public PathCaster {
 public:
  void cast(const AskedRays& rays, std::span<uint8_t> blocked) override {
    for (size_t i = 0; i < blocked.size(); ++i) blocked[i] = !std::isinf(rays.segments[i].t_max);
  }
};

TEST(PathPicture, OfOneBounceIsThePictureOfDirectLight) {
  for (const World& world : {one_object(), several_instances()}) {
    RenderSettings direct = small_picture();
    direct.pixel_samples = 64;
    const auto expected =
        render::render(world, direct, [&] { return std::make_unique<BvhShadows>(world, EmbreeQuery{1}); });
    const Image traced =
        must_trace(world, picture(1024), {.bounces = 1}, [&] { return std::make_unique<OnlyLights>(world); });
    const Vec3 a = mean(expected->image), b = mean(traced);
    EXPECT_NEAR(b.x, a.x, 0.02f * a.x);
    EXPECT_NEAR(b.y, a.y, 0.02f * a.y);
    EXPECT_NEAR(b.z, a.z, 0.02f * a.z);
  }
}

TEST(PathPicture, OpenGroundUnderTheSkyHasItsColourTimesTheSkys) {
  scenes::Scene scene = scenes::around(scene_mesh(triangle()));
  scene.instances[0].transform = {1, 0, 0, 3000, 0, 1, 0, 0, 0, 0, 1, 3000};
  scene.ground = {0, 0, 0, 50, {0.25f, 0.5f, 1}};
  scene.camera = {{0, 4, 6}, {0, 0, 0}, 1};
  const World world = must_build(std::move(scene));
  RenderSettings settings = picture(65536);
  settings.width = settings.height = 1;
  // From flat ground no path comes back to it: further bounces add nothing.
  const Image image = must_trace(world, settings, {.bounces = 4}, [] { return std::make_unique<OnlySky>(); });
  EXPECT_NEAR(image.pixels[0].x, 0.25f * kSky.x, 0.02f * kSky.x);
  EXPECT_NEAR(image.pixels[0].y, 0.5f * kSky.y, 0.02f * kSky.y);
  EXPECT_NEAR(image.pixels[0].z, kSky.z, 0.02f * kSky.z);
}

TEST(PathPicture, EachBounceAddsLight) {
  const World world = one_object();
  float before = 0;
  for (uint32_t bounces = 1; bounces <= kMostBounces; ++bounces) {
    const Image image = must_trace(world, picture(256), {.bounces = bounces},
                                   [&] { return std::make_unique<BvhPaths>(world, EmbreeQuery{1}); });
    EXPECT_GT(mean(image).y, before);
    before = mean(image).y;
  }
}

class Casters : public testing::TestWithParam<bool> {};

TEST_P(Casters, GiveOnePicture) {
  const bool wavefronts = GetParam();
  const PathPicture paths{.wavefronts = wavefronts};
  const TemporaryFolder folder;
  for (const World& world : {one_object(), several_instances()}) {
    baker::BakeOptions bake;
    bake.depth = 3, bake.method = Method::proven, bake.horizons = true;
    const WorldSidecars sidecars = must_bake(world, bake, folder);
    ASSERT_TRUE(have_hierarchies(sidecars.objects));
    const auto by_embree = [&](EmbreeQuery way) {
      return must_trace(world, picture(16), paths, [&] { return std::make_unique<BvhPaths>(world, way); });
    };
    const Image expected = by_embree({1});
    EXPECT_TRUE(same_bits(expected, by_embree({16})));
    EXPECT_TRUE(same_bits(expected, by_embree(fastest_way(world, picture(16), paths))));
    for (const bool by_horizons : {false, true}) {
      const SidecarPaths ours(world, sidecars.objects, by_horizons);
      for (const unsigned threads : {1u, 3u})
        EXPECT_TRUE(same_bits(expected, must_trace(world, picture(16, threads), paths, [&] {
                                return std::make_unique<HierarchyPaths>(ours, wavefronts);
                              })));
    }
    EXPECT_FALSE(
        same_bits(expected, must_trace(world, picture(16), paths, [] { return std::make_unique<OnlySky>(); })));
  }
}

INSTANTIATE_TEST_SUITE_P(Uses, Casters, testing::Values(false, true),
                         [](const auto& instance) { return instance.param ? "Wavefronts" : "SingleCalls"; });

TEST(AskedRays, FormArraysOfRaysThatBeginAlikeAndWavefrontsFewerOfThem) {
  const World world = one_object();
  std::vector<PathRay> rays = trace_paths(world, {2000, 4, 1});
  const auto check = [&](const AskedRays& asked) {
    ASSERT_EQ(asked.segments.size(), rays.size());
    size_t next = 0;
    for (const AskedRays::Array& array : asked.arrays) {
      EXPECT_EQ(array.first, next);
      EXPECT_TRUE(array.count >= 1 && array.count <= kWavefront);
      for (size_t i = array.first; i < array.first + array.count; ++i)
        EXPECT_EQ(asked.from[i], asked.from[array.first]);
      next += array.count;
    }
    EXPECT_EQ(next, rays.size());
  };
  const AskedRays paths(rays);
  check(paths);
  sort_as_wavefronts(rays);
  const AskedRays wavefronts(rays);
  check(wavefronts);
  EXPECT_LE(wavefronts.arrays.size(), 3 * kMostBounces);
  EXPECT_GT(paths.arrays.size(), 100u);
}

}  // namespace
}  // namespace vcd::test
