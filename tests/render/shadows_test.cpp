#include "render/shadows.h"

#include <random>

#include <gtest/gtest.h>

#include <vcd/baker/referee.h>
#include <vcd/runtime/scene.h>

#include "render/beam.h"
#include "render/census.h"
#include "render/recording.h"
#include "worlds.h"

namespace vcd::test {
namespace {

TEST(EmbreeQuery, AllWaysGiveTheSameAnswers) {
  const World world = several_instances();
  const Recording bundles = record(world, small_picture());
  uint64_t blocked = 0;
  for (size_t i = 0; i < bundles.size(); ++i) {
    const auto segments = bundles[i].segments;
    std::vector<uint8_t> expected(segments.size()), answers(segments.size());
    occluded(world.shadow_casters(), {1}, segments, expected.data());
    for (const EmbreeQuery& packets : world.ways_to_trace()) {
      occluded(world.shadow_casters(), packets, segments, answers.data());
      EXPECT_EQ(expected, answers) << name_of(packets);
    }
    for (uint8_t answer : expected) blocked += answer;
  }
  EXPECT_GT(blocked, 0u);
}

// Whether origin + t · direction, 0 ≤ t ≤ 1, meets a box, in double precision.
bool meets(const Segment& s, const Box& box) {
  double enter = 0, leave = 1;
  const float low[3] = {box.low.x, box.low.y, box.low.z}, high[3] = {box.high.x, box.high.y, box.high.z};
  for (int a = 0; a < 3; ++a) {
    const double o = s.origin[a], d = s.direction[a];
    if (d == 0) {
      if (o < low[a] || o > high[a]) return false;
      continue;
    }
    enter = std::max(enter, std::min((low[a] - o) / d, (high[a] - o) / d));
    leave = std::min(leave, std::max((low[a] - o) / d, (high[a] - o) / d));
  }
  return enter <= leave;
}

TEST(Beam, MayMeetEveryBoxThatASegmentOfTheBundleMeetsAndFewOthers) {
  std::mt19937 random(5);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random() >> 8) * 0x1p-24f;
  };
  std::vector<Box> boxes;
  for (int i = 0; i < 300; ++i) {
    const Vec3 low{uniform(-20, 20), uniform(0, 2), uniform(-20, 20)};
    boxes.push_back({low, low + Vec3{uniform(0.1f, 3), uniform(0.1f, 3), uniform(0.1f, 3)}});
  }
  uint64_t may = 0, met = 0;
  for (int bundle = 0; bundle < 300; ++bundle) {
    std::vector<Segment> segments;
    const float origin[3] = {uniform(-20, 20), uniform(0, 1), uniform(-20, 20)},
                target[3] = {uniform(-20, 20), uniform(0, 20), uniform(-20, 20)};
    for (int k = 0; k < 16; ++k) {
      Segment s{{origin[0], origin[1], origin[2]}, 0, {}, 1};
      for (int a = 0; a < 3; ++a) s.direction[a] = bundle % 7 == a ? 0 : target[a] + uniform(-1, 1) - origin[a];
      segments.push_back(s);
    }
    const Beam beam(segments);
    for (const Box& box : boxes) {
      bool any = false;
      for (const Segment& s : segments) any |= meets(s, box);
      EXPECT_TRUE(!any || beam.may_meet(box));
      met += any, may += beam.may_meet(box);
    }
  }
  EXPECT_GT(met, 100u);
  EXPECT_LT(may, 2 * met);
}

class Counting : public testing::TestWithParam<bool> {
 protected:
  Counting()
      : world_(GetParam() ? one_object() : several_instances()), sidecars_(must_bake(world_, quick(4, 81), folder_)) {
    counter_.emplace(std::move(*TestCounter::build(world_)));
  }
  TemporaryFolder folder_;
  World world_;
  WorldSidecars sidecars_;
  std::optional<TestCounter> counter_;
};

TEST_P(Counting, KindsAddUpToAllSegmentsAndCountsAreTheRuntimesOwn) {
  const RenderSettings settings = small_picture(3);
  const size_t pixels = size_t{settings.width} * settings.height;
  Census census(world_, sidecars_.objects, *counter_, {1}, pixels);
  const Rendered rendered = must_render(world_, settings, [&] { return census.caster(); });
  const CensusPass pass = census.take();
  const KindCounts total = pass.total();
  EXPECT_EQ(total.segments, rendered.shadow_segments);

  // The same picture's segments once more, one by one, with nothing but the runtime.
  std::vector<SceneInstance> instances;
  for (const WorldInstance& instance : world_.instances) {
    const Affine& m = instance.to_world;
    const Transform transform{{{m.column[0].x, m.column[1].x, m.column[2].x, m.offset.x},
                               {m.column[0].y, m.column[1].y, m.column[2].y, m.offset.y},
                               {m.column[0].z, m.column[1].z, m.column[2].z, m.offset.z}}};
    instances.push_back(SceneInstance::of(sidecars_.objects[instance.object], transform));
  }
  const auto scene = Scene::build(instances);
  ASSERT_TRUE(scene.ok());
  const Recording bundles = record(world_, settings);
  uint64_t answered[2] = {}, open = 0, kinds[kSegmentKinds] = {};
  for (size_t i = 0; i < bundles.size(); ++i)
    for (const Segment& s : bundles[i].segments) {
      ++kinds[static_cast<size_t>(segment_kind(world_, bundles[i].surface, s))];
      SceneQuery query;
      const uint32_t own = bundles[i].surface;
      if (own != kGroundSurface) query.origins = std::span(&own, 1);
      const Visibility answer = world_.single() ? sidecars_.objects[0].classify(s) : scene->classify(s, query);
      if (answer != Visibility::unclassified) ++answered[answer == Visibility::blocked];
    }
  // A bundle leaves its own instance open for all segments, one by one only for those that meet its box.
  EXPECT_LE(total.answered[0], answered[0]);
  EXPECT_GE(total.answered[0], answered[0] - (world_.single() ? 0 : answered[0] / 500));
  EXPECT_EQ(total.answered[1], answered[1]);
  open = total.segments - total.resolved();
  for (size_t k = 0; k < kSegmentKinds; ++k) EXPECT_EQ(pass.kinds[k].segments, kinds[k]) << k;
  EXPECT_GT(answered[0], 0u);
  EXPECT_EQ(answered[1] > 0, !world_.single());  // leaves alone block no cell; a ball does
  EXPECT_GT(open, 0u);

  double by_pixel = 0, tests = 0;
  for (double p : pass.pixel_open) by_pixel += p;
  for (double p : pass.pixel_tests) tests += p;
  EXPECT_EQ(by_pixel, static_cast<double>(open));
  EXPECT_EQ(tests, static_cast<double>(pass.tests));
}

TEST_P(Counting, TheCountedPictureIsTheVariantsOwnAndWrongAnswersShowInIt) {
  const RenderSettings settings = small_picture();
  Census census(world_, sidecars_.objects, *counter_, {1}, size_t{settings.width} * settings.height);
  const Image counted = must_render(world_, settings, [&] { return census.caster(); }).image;
  const Image plain = must_render(world_, settings, [&] {
                        return std::make_unique<SidecarShadows>(world_, sidecars_.objects, EmbreeQuery{1});
                      }).image;
  EXPECT_EQ(compare(counted, plain).pixels, 0u);
  const Image traced =
      must_render(world_, settings, [&] { return std::make_unique<BvhShadows>(world_, EmbreeQuery{1}); }).image;
  EXPECT_EQ(compare(counted, traced).pixels > 0, census.take().total().wrong > 0);
}

TEST_P(Counting, TheCountingHierarchyFindsWhatEmbreeFindsAndSidecarsSaveTests) {
  const Recording bundles = record(world_, small_picture());
  uint64_t differing = 0, all = 0, tests = 0;
  for (size_t i = 0; i < bundles.size(); ++i) {
    std::vector<uint8_t> traced(bundles[i].segments.size());
    occluded(world_.shadow_casters(), {1}, bundles[i].segments, traced.data());
    for (size_t k = 0; k < traced.size(); ++k) {
      const auto count = counter_->count(bundles[i].segments[k]);
      differing += count.occluded != (traced[k] != 0);
      EXPECT_TRUE(!count.occluded || count.tests > 0);
      tests += count.tests;
      ++all;
    }
  }
  EXPECT_LE(differing, all / 10000);
  Census with(world_, sidecars_.objects, *counter_, {1}, 24 * 16);
  must_render(world_, small_picture(), [&] { return with.caster(); });
  EXPECT_LT(with.take().tests, tests);
}

TEST(Judging, RemembersWhatEmbreeGotWrongAndOnlyThat) {
  const World world = one_object();
  const baker::Referee referee(world.objects[0].mesh);
  Judge judge(world, {});
  const Recording bundles = record(world, small_picture());
  const auto answers = [&](size_t bundle) {  // one in seven is wrong
    std::vector<uint8_t> blocked(bundles[bundle].segments.size());
    occluded(world.shadow_casters(), {1}, bundles[bundle].segments, blocked.data());
    for (size_t i = bundle % 7; i < blocked.size(); i += 7) blocked[i] ^= 1;
    return blocked;
  };
  for (size_t b = 0; b < bundles.size(); ++b) {
    std::vector<uint8_t> truth(bundles[b].segments.size());
    judge.learn(bundles[b].segments, answers(b), truth);
    for (size_t i = 0; i < truth.size(); ++i) EXPECT_EQ(truth[i] != 0, referee.occluded(bundles[b].segments[i]));
  }
  for (size_t b = 0; b < bundles.size(); ++b) {
    std::vector<uint8_t> corrected = answers(b);
    judge.correct(bundles[b].segments, corrected);
    for (size_t i = 0; i < corrected.size(); ++i)
      EXPECT_EQ(corrected[i] != 0, referee.occluded(bundles[b].segments[i]));
  }
}

class Liar : public ShadowCaster {
 public:
  explicit Liar(const World& world) : world_(world) {}
  void cast(const Bundle& bundle, std::span<uint8_t> blocked) override {
    occluded(world_.shadow_casters(), {1}, bundle.segments, blocked.data());
    for (size_t i = 0; i < bundle.segments.size(); ++i) blocked[i] ^= 1;
  }

 private:
  const World& world_;
};

TEST(Judging, AHierarchyIsNeverWrongAndALiarAlways) {
  const TemporaryFolder folder;
  const World world = one_object();
  const WorldSidecars sidecars = must_bake(world, quick(3, 16), folder);
  const TestCounter counter = std::move(*TestCounter::build(world));
  Judge judge(world, {});
  const auto total = [&](Census&& census) {
    must_render(world, small_picture(2), [&] { return census.caster(); });
    return census.take().total();
  };
  const KindCounts traced = total(Census(world, {}, counter, {1}, 24 * 16, &judge));
  EXPECT_LE(traced.wrong, traced.segments / 10000);
  const auto counted = [&](MakeCaster make) { return total(Census(world, std::move(make), {1}, 24 * 16, &judge)); };
  OpenOptions without_look_ups;
  without_look_ups.look_up = LookUpFirst::never;
  const auto exact = open_sidecars(world, {(folder / "world.vcd").string()}, without_look_ups);
  const KindCounts alone = counted([&] { return std::make_unique<HierarchyShadows>(world, exact->objects); });
  EXPECT_EQ(alone.wrong, 0u);
  EXPECT_EQ(alone.segments, traced.segments);
  EXPECT_EQ(alone.resolved(), traced.segments);
  EXPECT_GE(counted([&] { return std::make_unique<Liar>(world); }).wrong, traced.segments - traced.wrong);
}

INSTANTIATE_TEST_SUITE_P(Worlds, Counting, testing::Values(true, false),
                         [](const auto& instance) { return instance.param ? "OneObject" : "Instances"; });

}  // namespace
}  // namespace vcd::test
