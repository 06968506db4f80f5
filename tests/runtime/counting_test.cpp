#include <vcd/runtime/counting.h>

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include <vcd/runtime/vcd.h>

#include "support/files.h"
#include "support/meshes.h"
#include "support/random.h"

namespace vcd::test {
namespace {

class CountingTest : public testing::Test {
 protected:
  CountingTest() {
    FloatRandom random(1);
    for (Segment& s : segments_)
      s = {{random.between(-3, 3), random.between(-3, 3), 3}, 0, {random.between(-1, 1), random.between(-1, 1), -4}, 2};
  }
  AnswerCounts by_hand(const std::vector<Visibility>& answers) const {
    const auto count = [&](Visibility v) {
      return static_cast<uint64_t>(std::count(answers.begin(), answers.end(), v));
    };
    return {count(Visibility::clear), count(Visibility::blocked), count(Visibility::unclassified)};
  }
  static void expect_equal(const AnswerCounts& a, const AnswerCounts& b) {
    EXPECT_EQ(a.clear, b.clear);
    EXPECT_EQ(a.blocked, b.blocked);
    EXPECT_EQ(a.unclassified, b.unclassified);
  }

  baker::BakedObject baked_ = must_bake(sphere(), proven(3));
  std::vector<std::byte> bytes_ = sidecar_bytes({&baked_});
  Sidecar sidecar_ = std::move(*Sidecar::open_buffer(bytes_));
  Object object_ = sidecar_.object(0);
  std::vector<Segment> segments_ = std::vector<Segment>(500);
};

TEST_F(CountingTest, CountsWhatAnObjectAnswers) {
  std::vector<Visibility> answers(segments_.size());
  object_.classify(segments_, answers);
  const AnswerCounts expected = by_hand(answers);
  EXPECT_GT(expected.clear, 50u);
  EXPECT_GT(expected.blocked, 20u);
  EXPECT_GT(expected.unclassified, 10u);
  EXPECT_EQ(expected.asked(), segments_.size());
  EXPECT_EQ(expected.answered(), segments_.size() - expected.unclassified);

  AnswerCounts arrays, single, fallback;
  std::vector<Visibility> counted(segments_.size());
  Counting(object_, arrays).classify(segments_, counted);
  EXPECT_EQ(counted, answers);
  size_t asked = 0;
  for (size_t i = 0; i < segments_.size(); ++i) {
    EXPECT_EQ(Counting(object_, single).classify(segments_[i]), answers[i]);
    const bool blocked = Counting(object_, fallback).occluded(segments_[i], [&] { return ++asked, true; });
    EXPECT_EQ(blocked, answers[i] != Visibility::clear);
  }
  EXPECT_EQ(asked, expected.unclassified);
  for (const AnswerCounts& counts : {arrays, single, fallback}) expect_equal(counts, expected);
  AnswerCounts sum = arrays;
  sum += single;
  EXPECT_EQ(sum.asked(), 2 * segments_.size());
}

TEST_F(CountingTest, CountsBundlesAndScenes) {
  std::array<float, 100> u, v;
  for (size_t i = 0; i < u.size(); ++i) u[i] = static_cast<float>(i % 10) / 10, v[i] = static_cast<float>(i / 10) / 10;
  const QuadBundle bundle{{0.5f, 0.2f, 3}, {-4, -4, -3}, {8, 0, 0}, {0, 8, 0}, u, v};
  std::array<uint64_t, 2> blocked, unclassified;
  object_.classify(bundle, blocked, unclassified);
  std::vector<Visibility> answers(u.size());
  for (size_t i = 0; i < u.size(); ++i)
    answers[i] = blocked[i / 64] >> i % 64 & 1        ? Visibility::blocked
                 : unclassified[i / 64] >> i % 64 & 1 ? Visibility::unclassified
                                                      : Visibility::clear;
  AnswerCounts counts;
  Counting(object_, counts).classify(bundle, blocked, unclassified);
  expect_equal(counts, by_hand(answers));
  EXPECT_GT(counts.blocked, 0u);
  EXPECT_GT(counts.clear, 0u);

  const SceneInstance instance = SceneInstance::of(object_, {{{1, 0, 0, 1}, {0, 1, 0, 0}, {0, 0, 1, 0}}});
  const Scene scene = std::move(*Scene::build(std::span(&instance, 1)));
  std::vector<Visibility> of_scene(segments_.size()), counted(segments_.size());
  scene.classify(segments_, of_scene, {1});
  AnswerCounts scene_counts;
  Counting(scene, scene_counts).classify(segments_, counted, SceneQuery{1});
  EXPECT_EQ(counted, of_scene);
  expect_equal(scene_counts, by_hand(of_scene));
}

TEST_F(CountingTest, IsTheSameInC) {
  std::vector<Visibility> answers(segments_.size());
  AnswerCounts expected;
  Counting(object_, expected).classify(segments_, answers);
  vcd_answer_counts counts{};
  for (int times = 0; times < 2; ++times)
    vcd_count_answers(&counts, reinterpret_cast<const uint8_t*>(answers.data()), answers.size());
  EXPECT_EQ(counts.clear, 2 * expected.clear);
  EXPECT_EQ(counts.blocked, 2 * expected.blocked);
  EXPECT_EQ(counts.unclassified, 2 * expected.unclassified);

  const uint64_t blocked[] = {0b0110, 1}, unclassified[] = {0b1000, 2};
  counts = {};
  vcd_count_bundle(&counts, blocked, unclassified, 66);
  EXPECT_EQ(counts.blocked, 3u);
  EXPECT_EQ(counts.unclassified, 2u);
  EXPECT_EQ(counts.clear, 61u);
}

}  // namespace
}  // namespace vcd::test
