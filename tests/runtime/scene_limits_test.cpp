// Scenes at the limits: instances that are flat, hidden, not finite, tiny or huge, and segments of such sizes, against
// exact arithmetic. The fuzz target `scenes` looks for more of the kind.
#include <vcd/runtime/scene.h>

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "support/exact_world.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/special_floats.h"

namespace vcd::test {
namespace {

constexpr Transform scaled(float x, float y, float z, float at = 0) {
  return {{{x, 0, 0, at}, {0, y, 0, 0}, {0, 0, z, 0}}};
}

class SceneLimits : public testing::Test {
 protected:
  Object object() const { return sidecar_.object(0); }
  SceneInstance at(const Transform& t, bool with_sidecar = true) const {
    SceneInstance instance = SceneInstance::of(object(), t);
    if (!with_sidecar) instance.object.reset();
    return instance;
  }

  // What a caller is told who knows the truth of each instance: every way to ask, by every kernel.
  void expect_truth(const std::vector<SceneInstance>& instances, const std::vector<Segment>& segments) const {
    for (const std::string& kernel : kernels()) {
      const auto scene = Scene::build(instances, kernel);
      ASSERT_TRUE(scene.ok()) << scene.error().message;
      const auto meets = [&](uint32_t i, const Segment& s) {
        return scene->use(i) != InstanceUse::absent && ExactInstance(mesh_, instances[i].to_world).meets(s);
      };
      std::vector<uint64_t> blocked((segments.size() + 63) / 64);
      scene->occluded(segments, blocked, [&](const UnclassifiedSegments& left) {
        for (size_t k = 0; k < left.segments.count; ++k) {
          EXPECT_EQ(left.in_world, !scene->in_object(left.instance, segments[left.indices[k]]).has_value());
          left.blocked[k] = meets(left.instance, segments[left.indices[k]]);
        }
      });
      for (size_t k = 0; k < segments.size(); ++k) {
        const Segment& s = segments[k];
        bool truth = false;
        for (uint32_t i = 0; i < instances.size(); ++i) truth |= meets(i, s);
        EXPECT_EQ(blocked[k / 64] >> (k % 64) & 1, truth) << kernel << ", segment " << k;
        EXPECT_EQ(scene->occluded(s, [&](uint32_t i) { return meets(i, s); }), truth) << kernel << ", segment " << k;
        const Visibility answer = scene->classify(s);
        EXPECT_TRUE(answer == Visibility::unclassified || (answer == Visibility::blocked) == truth)
            << kernel << ", segment " << k;
      }
    }
  }

  baker::SourceMesh mesh_ = cube();
  baker::BakedObject baked_ = must_bake(mesh_, proven(3));
  std::vector<std::byte> bytes_ = sidecar_bytes({&baked_});
  Sidecar sidecar_ = std::move(*Sidecar::open_buffer(bytes_));
};

struct Odd {
  const char* what;
  Transform transform;
  InstanceUse use;  // with a sidecar
};
constexpr auto kAsked = InstanceUse::asked, kLeft = InstanceUse::left, kAbsent = InstanceUse::absent;
constexpr Odd kOddInstances[] = {
    {"moved", scaled(1, 1, 1, 9), kAsked},
    {"hidden by a scale of 0", scaled(0, 0, 0, 9), kAbsent},
    {"flattened to a plane", scaled(1, 0, 1, 9), kLeft},
    {"flattened to a line", scaled(0, 0, 1, 9), kLeft},
    {"very flat, but not quite", scaled(1, 1e-7f, 1, 9), kAsked},
    {"turned and flattened", {{{1, 1, 0, 9}, {1, 1, 0, 0}, {0, 0, 1, 0}}}, kLeft},
    {"nearly singular", {{{1, 1, 0, 9}, {1, 1 + 0x1p-23f, 0, 0}, {0.3f, 0.7f, 1e-12f, 0}}}, kLeft},
    {"sheared", {{{1, 0, 0, 9}, {2e6f, 1, 0, 0}, {0, 0, 1, 0}}}, kAsked},
    {"tiny", scaled(1e-20f, 1e-20f, 1e-20f, 9), kLeft},
    {"tinier", scaled(1e-38f, 1e-38f, 1e-38f, 9), kLeft},
    {"subnormal", scaled(1e-44f, 1e-44f, 1e-44f, 9), kLeft},
    {"huge", scaled(1e20f, 1e20f, 1e20f, 9), kAsked},
    {"hugest", scaled(3e38f, 3e38f, 3e38f, 9), kLeft},
    {"far", scaled(1, 1, 1, 1e30f), kLeft},
    {"infinite", scaled(1, kInfinity, 1), kLeft},
    {"infinitely far", scaled(1, 1, 1, kInfinity), kLeft},
    {"no number", scaled(1, 1, kNaN), kLeft},
    {"a point nowhere", scaled(0, 0, 0, kNaN), kLeft},
};

TEST_F(SceneLimits, OneInstanceThatCannotBeLookedUpStopsNoOther) {
  const std::vector<Segment> segments = {{{-5, 0.4f, 0.45f}, 0, {10, 0, 0}, 1},
                                         {{-5, 0.4f, 0.45f}, 0, {30, 0, 0}, 1},
                                         {{9.5f, -3, 0.5f}, 0, {0, 9, 0.1f}, 1},
                                         {{9, 0, -3}, 0, {0, 0, 9}, 1},
                                         {{-5, 7, 7}, 0, {40, 0, 0}, kInfinity}};
  for (const Odd& odd : kOddInstances)
    for (const bool with_sidecar : {true, false}) {
      SCOPED_TRACE(odd.what);
      const std::vector<SceneInstance> instances = {at(kStill), at(odd.transform, with_sidecar)};
      const auto scene = Scene::build(instances);
      ASSERT_TRUE(scene.ok());
      EXPECT_EQ(scene->use(0), kAsked);
      EXPECT_EQ(scene->use(1), !with_sidecar && odd.use == kAsked ? kLeft : odd.use);
      EXPECT_EQ(scene->classify(segments[0]), Visibility::blocked);
      bool finite = true;
      for (const auto& row : odd.transform.rows)
        for (const float x : row) finite &= std::isfinite(x);
      if (finite) expect_truth(instances, segments);
      // What has no box is left to the caller everywhere, and only that.
      uint64_t asked = 0;
      scene->occluded(segments[4], [&](uint32_t) { return ++asked, false; });
      const bool everywhere = !finite || std::abs(odd.transform.rows[0][0]) > 1e12f || odd.transform.rows[0][3] > 1e12f;
      EXPECT_EQ(asked, everywhere ? 1u : 0u);
    }
}

TEST_F(SceneLimits, InstancesComeAndGoWithTheirTransforms) {
  auto scene = Scene::build(std::vector{at(kStill), at(kStill), at(kStill)});
  const Segment through{{-1, 0.4f, 0.5f}, 0, {3, 0, 0}, 1};
  const auto moved = [&](const Transform& t) {
    const auto error = scene->set_transforms(std::vector{scaled(1, 1, 1, 9), t, scaled(1, 1, 1, 9)});
    EXPECT_FALSE(error.has_value());
    return scene->classify(through);
  };
  EXPECT_EQ(moved(kStill), Visibility::blocked);
  EXPECT_EQ(moved(scaled(0, 0, 0)), Visibility::clear);
  EXPECT_EQ(scene->use(1), InstanceUse::absent);
  EXPECT_EQ(moved(scaled(0, 1, 1)), Visibility::unclassified);
  EXPECT_EQ(scene->use(1), InstanceUse::left);
  EXPECT_EQ(moved(scaled(kNaN, 1, 1)), Visibility::unclassified);
  EXPECT_EQ(moved(kStill), Visibility::blocked);
  EXPECT_EQ(scene->use(1), InstanceUse::asked);
}

// Not even where segments are said to begin on it, or could meet anything.
TEST_F(SceneLimits, NobodyIsAskedOfWhatIsAbsent) {
  const auto scene = Scene::build(std::vector{at(scaled(0, 0, 0)), at(scaled(1, 1, 1, 9))});
  const std::vector<Segment> segments = {{{-1, 0, 0}, 0, {3, 0, 0}, 1}, {{kNaN, 0, 0}, 0, {3, 0, 0}, 1}};
  const std::vector<uint32_t> origins = {0, 0};
  const SceneQuery query{0xFFFFFFFF, origins};
  uint64_t blocked = 0;
  scene->occluded(
      segments, std::span(&blocked, 1), [](const UnclassifiedSegments& left) { EXPECT_EQ(left.instance, 1u); }, query);
  const auto nobody = [](uint32_t i) {
    EXPECT_EQ(i, 1u);
    return false;
  };
  for (const Segment& s : segments) EXPECT_FALSE(scene->occluded(s, nobody, query));
}

TEST_F(SceneLimits, BoxesMayBeAnything) {
  struct Box {
    float low, high;
    InstanceUse use;
    bool met;
  };
  const Segment through{{-1, 0.4f, 0.5f}, 0, {3, 0, 0}, 1};
  for (const Box& box : {Box{0, 1, kLeft, true}, Box{5, 6, kLeft, false}, Box{1, 0, kAbsent, false},
                         Box{kInfinity, -kInfinity, kAbsent, false}, Box{-kInfinity, kInfinity, kLeft, true},
                         Box{kNaN, 1, kLeft, true}, Box{-1e38f, 3e38f, kLeft, true}}) {
    SceneInstance instance{std::nullopt, {box.low, box.low, box.low}, {box.high, box.high, box.high}, kStill};
    const auto scene = Scene::build(std::span(&instance, 1));
    ASSERT_TRUE(scene.ok());
    EXPECT_EQ(scene->use(0), box.use) << box.low;
    EXPECT_EQ(scene->classify(through), box.met ? Visibility::unclassified : Visibility::clear) << box.low;
    // As flat as a picture: its box has room about it.
    instance = {std::nullopt, {0.5f, box.low, box.low}, {0.5f, box.high, box.high}, kStill};
    EXPECT_EQ(Scene::build(std::span(&instance, 1))->use(0), box.use) << box.low;
  }
}

// A walk through the hierarchy that takes components below 10^-37 for 10^-37 misses what these segments meet.
TEST_F(SceneLimits, SegmentsOfAnyScaleMissNothing) {
  const auto towards = [](float size, float direction, float t_max) {
    return Segment{{-30 * size, 0.5f * size, 0.5f * size}, 0, {direction, 0, 0}, t_max};
  };
  for (const float direction : {3e-38f, 1e-36f, 1e-44f, 1e-30f, 1e-20f, 1e-9f, 1.0f, 1e9f, 1e20f, 3e38f})
    for (const float scale : {1.0f, 1e-30f, 1e-36f, 1e-10f, 1e10f, 1e30f})
      for (const float t_max : {kInfinity, 1.0f, 60 * scale / direction}) {
        SCOPED_TRACE(testing::Message() << "scale " << scale << ", direction " << direction << ", t_max " << t_max);
        expect_truth({at(scaled(scale, scale, scale))},
                     {towards(scale, direction, t_max), towards(scale, -direction, t_max)});
      }
}

// Ever larger boxes ever farther away, of which splits by surface take off one after another, many in one place, and
// one without a box: no path through the hierarchy becomes too long, and no instance is lost.
TEST_F(SceneLimits, HierarchiesOfAnyShapeMissNothing) {
  std::vector<SceneInstance> instances;
  const auto add = [&](float size, float at_x) { instances.push_back(at(scaled(size, size, size, at_x), false)); };
  for (float x = 1e-6f; x < 1e11f; x *= 1.015f) add(x * 0.01f, x);
  for (int i = 0; i < 40; ++i) add(1, -50);
  for (const bool one_is_everywhere : {false, true}) {
    if (one_is_everywhere) add(kInfinity, 0);
    const auto scene = Scene::build(instances);
    for (uint32_t i = 0; i < instances.size(); i += 7) {
      const auto& rows = instances[i].to_world.rows;
      const float size = rows[0][0];
      if (!std::isfinite(size)) continue;
      const Segment through{{rows[0][3] + 0.5f * size, 0.5f * size, -size}, 0, {0, 0, 3 * size}, 1};
      bool asked = false, asked_everywhere = false;
      size_t count = 0;
      scene->occluded(through, [&](uint32_t k) {
        asked |= k == i, asked_everywhere |= one_is_everywhere && k + 1 == instances.size();
        return ++count, false;
      });
      EXPECT_TRUE(asked) << i;
      EXPECT_EQ(asked_everywhere, one_is_everywhere);
      EXPECT_LE(count, 42u) << i;
    }
  }
}

// Far or short segments that a trusted segment of the same scene is not like.
TEST_F(SceneLimits, OnlyWhatIsBeyondTheLimitsIsLeftToAllInstances) {
  const auto scene = Scene::build(std::vector{at(kStill), at(scaled(1, 1, 1, 5))});
  const auto asked = [&](const Segment& s) {
    uint64_t count = 0;
    scene->occluded(s, [&](uint32_t) { return ++count, false; });
    return count;
  };
  const Segment beside{{0, 3, 0}, 0, {9, 0, 0}, 1};
  const auto with_direction = [&](float x, float t_max) {
    Segment s = beside;
    return s.direction[0] = x, s.t_max = t_max, s;
  };
  EXPECT_EQ(asked(beside), 0u);
  EXPECT_EQ(asked(with_direction(0, 1)), 0u);       // a point
  EXPECT_EQ(asked(with_direction(1e-40f, 1)), 0u);  // nearly one
  EXPECT_EQ(asked(with_direction(0x1p-30f, kInfinity)), 0u);
  EXPECT_EQ(asked(with_direction(0x1p-31f, kInfinity)), 2u);
  EXPECT_EQ(asked(with_direction(0x1p40f, 1)), 0u);
  EXPECT_EQ(asked(with_direction(0x1p41f, 1)), 2u);
  Segment s = beside;
  s.t_min = -kInfinity;
  EXPECT_EQ(asked(s), 0u);
  s.t_min = kNaN;
  EXPECT_EQ(asked(s), 2u);
  s = beside, s.origin[1] = 0x1p41f;
  EXPECT_EQ(asked(s), 2u);
}

}  // namespace
}  // namespace vcd::test
