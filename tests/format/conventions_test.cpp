// One test for each sentence of spec/conventions.md, in its order and named after it.
#include <bit>
#include <random>

#include <gtest/gtest.h>

#include <vcd/baker/audit.h>
#include <vcd/baker/referee.h>
#include <vcd/format/tree.h>
#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>

#include "support/files.h"
#include "support/meshes.h"
#include "support/special_floats.h"

namespace vcd::test {
using namespace baker;
namespace {

// A sphere of radius 1 about the origin: lines near the axes are blocked, lines near the box's edges clear.
class Conventions : public testing::Test {
 protected:
  static void SetUpTestSuite() { baked_ = new BakedObject(must_bake(sphere(), proven(4))); }
  static void TearDownTestSuite() { delete baked_; }

  static Visibility ask(const Segment& s) {
    return classify(make_grid_frame(baked_->record.box_min, baked_->record.box_max), baked_->tree(),
                    baked_->tree().shape, s);
  }
  static Segment blocked() { return {{0.1f, 0.1f, -5}, 0, {0, 0, 10}, 1}; }
  static Segment clear() { return {{0.95f, 0.95f, -5}, 0, {0, 0, 10}, 1}; }
  static inline BakedObject* baked_;
};

TEST_F(Conventions, S01_ASegmentIsAnOpenIntervalInTheObjectsFrame) {
  EXPECT_EQ(ask(blocked()), Visibility::blocked);
  EXPECT_EQ(ask(clear()), Visibility::clear);
  Segment s = blocked();
  s.t_max = 0.2f;  // ends before the box
  EXPECT_EQ(ask(s), Visibility::clear);
}

TEST_F(Conventions, S02_TheDirectionMayHaveAnyLength) {
  for (float factor = 0x1p-20f; factor < 0x1p21f; factor *= 4)
    for (Segment s : {blocked(), clear()}) {
      const Visibility expected = ask(s);
      for (float& d : s.direction) d *= factor;
      s.t_max /= factor;
      EXPECT_EQ(ask(s), expected) << factor;
    }
}

TEST_F(Conventions, S03_TheIntervalMayBeNegativeOrInfinite) {
  Segment s = blocked();
  s.origin[2] = 5;
  s.t_min = -1;
  s.t_max = 0;
  EXPECT_EQ(ask(s), Visibility::blocked);
  s = blocked();
  s.t_max = kInfinity;
  s.t_min = -kInfinity;
  EXPECT_EQ(ask(s), Visibility::blocked);
}

TEST_F(Conventions, S04_AnEmptyIntervalIsNeverBlocked) {
  std::mt19937 random(1);
  for (int i = 0; i < 10000; ++i) {
    Segment s = blocked();
    s.t_min = static_cast<float>(random() % 1000) / 500;
    s.t_max = s.t_min - static_cast<float>(random() % 1000) / 500;
    EXPECT_NE(ask(s), Visibility::blocked);
  }
}

TEST_F(Conventions, S05_ReversingAgreesUpToRounding) {
  auto mesh = prepare(sphere());
  for (const Segment& s : audit_segments(*mesh, AuditKind::chords, 5, 100000)) {
    Segment back = s;
    back.t_min = 0, back.t_max = s.t_max - s.t_min;
    for (int a = 0; a < 3; ++a) {
      back.origin[a] = s.origin[a] + s.t_max * s.direction[a];
      back.direction[a] = -s.direction[a];
    }
    const Visibility one = ask(s), two = ask(back);
    if (one != two) {
      EXPECT_TRUE(one == Visibility::unclassified || two == Visibility::unclassified);
    }
  }
}

// 6, 7 and 20: proofs hold for all lines.
TEST_F(Conventions, S06_S07_S20_ClearAndBlockedAreKept) {
  auto mesh = prepare(sphere());
  AuditOptions options;
  options.lines = 100000;
  const auto report = audit(*mesh, answers_of(baked_->record, baked_->tree()), no_answers(), options);
  uint64_t wrong = 0, answered = 0;
  for (const AuditCounts& c : report.counts) {
    wrong += c.wrong[0] + c.wrong[1];
    answered += c.answered[0] + c.answered[1];
  }
  EXPECT_GT(answered, 50000u);
  EXPECT_EQ(wrong, 0u);
}

TEST_F(Conventions, S07_BlockedOnlyForSegmentsThatPierceTheBox) {
  Segment s = blocked();
  s.t_max = 0.5f;  // ends at the centre
  EXPECT_NE(ask(s), Visibility::blocked);
  s = blocked();
  s.t_min = 0.5f;
  EXPECT_NE(ask(s), Visibility::blocked);
}

TEST_F(Conventions, S08_UnclassifiedIsGivenToGrazingLines) {
  EXPECT_EQ(ask({{0.999f, 0, -5}, 0, {0, 0, 10}, 1}), Visibility::unclassified);
}

TEST_F(Conventions, S09_OutsideTheBoxIsClear) {
  EXPECT_EQ(ask({{2, 2, -5}, 0, {0, 0, 10}, 1}), Visibility::clear);
  EXPECT_EQ(ask({{0, 0, -5}, 0, {0, 0, 3.9f}, 1}), Visibility::clear);
  EXPECT_EQ(ask({{0, 0, 1.1f}, 0, {0, 0, 10}, 1}), Visibility::clear);
}

TEST_F(Conventions, S10_AnEndInsideTheBoxIsClearInClearCellsOnly) {
  EXPECT_EQ(ask({{0.95f, 0.95f, 0}, 0, {0, 0, 10}, 1}), Visibility::clear);
  EXPECT_EQ(ask({{0.1f, 0.1f, 0}, 0, {0, 0, 10}, 1}), Visibility::unclassified);
}

TEST_F(Conventions, S11_WithoutClearCellsAnEndInsideIsNotLookedUp) {
  TreeView tree = baked_->tree();
  tree.answers = answer_table(Trust::statistics, kAllClasses & ~just(CellClass::clear));
  tree.top = nullptr;  // a look-up would crash
  const GridFrame frame = make_grid_frame(baked_->record.box_min, baked_->record.box_max);
  const Segment s = {{0.95f, 0.95f, 0}, 0, {0, 0, 10}, 1};
  EXPECT_EQ(classify(frame, tree, tree.shape, s), Visibility::unclassified);
}

TEST_F(Conventions, S12_NaNOrInfinityIsUnclassified) {
  for (float bad : {kNaN, kInfinity, -kInfinity})
    for (int a = 0; a < 3; ++a) {
      Segment s = clear();
      s.origin[a] = bad;
      EXPECT_EQ(ask(s), Visibility::unclassified);
      s = clear();
      s.direction[a] = bad;
      EXPECT_EQ(ask(s), Visibility::unclassified);
    }
}

TEST_F(Conventions, S13_ZeroLengthIsUnclassified) {
  EXPECT_EQ(ask({{0.95f, 0.95f, -5}, 0, {0, 0, 0}, 1}), Visibility::unclassified);
  EXPECT_EQ(ask({{0.95f, 0.95f, -5}, 0, {-0.0f, 0, -0.0f}, 1}), Visibility::unclassified);
}

TEST_F(Conventions, S14_TooShortOrLongDirectionsAreUnclassified) {
  EXPECT_EQ(ask({{0.95f, 0.95f, -5}, 0, {0, 0, 0x1p-48f}, 1}), Visibility::unclassified);
  EXPECT_EQ(ask({{0.95f, 0.95f, -5}, 0, {0, 0, 0x1p94f}, 1}), Visibility::unclassified);
}

TEST_F(Conventions, S15_FarOriginsAreUnclassified) {
  EXPECT_EQ(ask({{0.95f, 0.95f, -1000}, 0, {0, 0, 2000}, 1}), Visibility::clear);
  EXPECT_EQ(ask({{0.95f, 0.95f, -1100}, 0, {0, 0, 2200}, 1}), Visibility::unclassified);
}

TEST_F(Conventions, S16_NaNAsAnEndIsNeverBlocked) {
  Segment s = blocked();
  s.t_min = kNaN;
  EXPECT_EQ(ask(s), Visibility::unclassified);
  s = blocked();
  s.t_max = kNaN;
  EXPECT_EQ(ask(s), Visibility::unclassified);
}

TEST_F(Conventions, S17_ComponentsMayBeZeroOrSubnormal) {
  for (float tiny : {0.0f, -0.0f, 1e-40f, -1e-40f, 1e-35f}) {
    EXPECT_EQ(ask({{0.1f, 0.1f, -5}, 0, {tiny, tiny, 10}, 1}), Visibility::blocked);
    EXPECT_EQ(ask({{0.95f, 0.95f, -5}, 0, {tiny, -tiny, 10}, 1}), Visibility::clear);
  }
}

TEST_F(Conventions, S18_LinesInAFaceOfTheBoxAreNeverBlocked) {
  const ObjectRecord& r = baked_->record;
  for (float x : {r.box_min[0], r.box_max[0]})
    for (float y : {-0.5f, 0.0f, 0.5f}) EXPECT_NE(ask({{x, y, -5}, 0, {0, 0, 10}, 1}), Visibility::blocked);
}

TEST_F(Conventions, S19_LinesThroughEdgesAndCornersGoToTheLowestAxis) {
  const float low[3] = {0, 0, 0}, high[3] = {256, 256, 256};
  const LineCell line = locate(make_grid_frame(low, high), {{-10, -10, -10}, 0, {1, 1, 1}, 1000});
  EXPECT_TRUE(line.hits);
  EXPECT_EQ(line.pair, 0u);  // faces 0 and 1: axis x for entry and exit
}

// ---- With a hierarchy

class WithAHierarchy : public testing::Test {
 protected:
  explicit WithAHierarchy(
      const SourceMesh& source = {"two", 0, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {4, 4, 0}}, {{0, 1, 2}, {1, 2, 3}}})
      : baked_(must_bake(source, proven(2))),
        bytes_(sidecar_bytes({&baked_})),
        sidecar_(std::move(*Sidecar::open_buffer(bytes_))) {}
  bool ask(const Segment& s) const { return sidecar_.object(0).occluded(s, From::self); }

  BakedObject baked_;
  std::vector<std::byte> bytes_;
  Sidecar sidecar_;
};

TEST_F(WithAHierarchy, S21_EverySegmentIsAnsweredExactly) {
  EXPECT_TRUE(ask({{1, 1, 1}, 0, {0, 0, -1}, 2}));              // inside
  EXPECT_TRUE(ask({{2, 2, 1}, 0, {0, 0, -1}, 2}));              // the edge between the two
  EXPECT_TRUE(ask({{0, 0, 1}, 0, {0, 0, -1}, 2}));              // a vertex
  EXPECT_FALSE(ask({{-0x1p-140f, 0, 1}, 0, {0, 0, -1}, 2}));    // beside it
  EXPECT_TRUE(ask({{-1, 1, 0}, 0, {9, 0, 0}, 1}));              // in the plane
  EXPECT_FALSE(ask({{1, 1, 1}, 0, {0, 0, -1}, 1}));             // ends on it
  EXPECT_TRUE(ask({{1, 1, 1}, 0, {0, 0, -1}, 0x1.000002p0f}));  // beyond
  EXPECT_TRUE(ask({{1, 1, 0x1p60f}, 0, {0, 0, -0x1p61f}, 1}));  // from far away
  EXPECT_FALSE(ask({{1, 1, 0}, 0, {0, 0, 1}, 1}));              // begins on it
}

TEST_F(WithAHierarchy, S22_WhatIsNoSegmentIsNotBlocked) {
  EXPECT_FALSE(ask({{kNaN, 1, 1}, 0, {0, 0, -1}, 2}));
  EXPECT_FALSE(ask({{1, 1, 1}, 0, {0, 0, -kInfinity}, 2}));
  EXPECT_FALSE(ask({{1, 1, 1}, kNaN, {0, 0, -1}, 2}));
  EXPECT_FALSE(ask({{1, 1, 1}, 2, {0, 0, -1}, 2}));
  EXPECT_TRUE(ask({{1, 1, 0}, 0, {0, 0, 0}, 1}));
  EXPECT_FALSE(ask({{1, 1, 1}, 0, {0, 0, 0}, 1}));
}

TEST_F(WithAHierarchy, S23_InASceneTheMovedSegmentIsAsked) {
  const Transform tenth = {{{0.1f, 0, 0, 5}, {0, 0.1f, 0, 5}, {0, 0, 0.1f, 5}}},
                  flat = {{{1, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 1, 0}}};
  for (const Transform& t : {tenth, flat}) {
    const SceneInstance instance = SceneInstance::of(sidecar_.object(0), t);
    const auto scene = Scene::build(std::span(&instance, 1));
    ASSERT_TRUE(scene.ok() && scene->has_hierarchies());
    const Segment s{{5.1f, 5.1f, 9}, 0, {0, 0, -8}, 1};
    if (const auto moved = scene->in_object(0, s)) {
      EXPECT_EQ(scene->occluded(s), ask(*moved));
      EXPECT_TRUE(ask(*moved));
    } else {
      EXPECT_FALSE(scene->occluded(s));  // a line in the plane y = 0 is all that is left
    }
  }
}

TEST_F(WithAHierarchy, S24_StatisticsAreRefusedWithProvenOnly) {
  // A sphere of many triangles, baked by few samples: what is blocked by samples alone is traced when proofs alone are
  // trusted.
  const BakedObject baked = must_bake(leaves(80), quick(3));
  const auto bytes = sidecar_bytes({&baked});
  OpenOptions options;
  options.look_up = LookUpFirst::always;
  const Sidecar all = std::move(*Sidecar::open_buffer(bytes, options));
  options.proven_only = true;
  const Sidecar sure = std::move(*Sidecar::open_buffer(bytes, options));
  const PreparedMesh mesh = *prepare(leaves(80));
  const Referee referee(mesh);
  int wrong = 0;
  for (const Segment& s : audit_segments(mesh, AuditKind::uniform, 5, kSanitized ? 4000 : 20000)) {
    const bool expected = referee.occluded(s);
    EXPECT_EQ(sure.object(0).occluded(s), expected);
    wrong += all.object(0).occluded(s) != expected;
  }
  EXPECT_GT(wrong, 0);
}

}  // namespace
}  // namespace vcd::test
