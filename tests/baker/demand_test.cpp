// Bakes for a demand: deep where it asks, right everywhere.
#include <vcd/baker/demand.h>

#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <vcd/baker/bake.h>
#include <vcd/baker/referee.h>
#include <vcd/runtime/sidecar.h>
#include <vcd/writer/demand.h>

#include "classify/make_classifier.h"
#include "octree/dag.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/random.h"

namespace vcd::test {
using namespace baker;
namespace {

// All layouts of trees; with sanitizers the two that differ most.
const std::vector kDepths = kSanitized ? std::vector{2u, 8u} : std::vector{2u, 5u, 6u, 7u, 8u};

PreparedMesh prepared(SourceMesh mesh) { return *prepare(std::move(mesh)); }
PreparedMesh foliage() { return prepared(leaves(60)); }

// From a floor below the mesh to a light above it, as shadow rays of a picture run; a tenth begins in the mesh's box.
// wide: the part of the floor, and of the light, that is used.
std::vector<AskedSegment> shadow_rays(const PreparedMesh& mesh, size_t count, uint64_t seed, float wide = 1) {
  FloatRandom random(seed);
  std::array<float, 3> size{};
  for (size_t a = 0; a < 3; ++a) size[a] = mesh.box_max[a] - mesh.box_min[a];
  std::vector<AskedSegment> segments;
  for (size_t i = 0; i < count; ++i) {
    const float from[] = {mesh.box_min[0] + size[0] * random.between(0.5f - 0.3f * wide, 0.5f + 0.3f * wide),
                          mesh.box_min[1] + size[1] * (i % 10 == 0 ? 0.5f : -0.1f),
                          mesh.box_min[2] + size[2] * random.between(0.5f - 0.3f * wide, 0.5f + 0.3f * wide)};
    const float to[] = {mesh.box_min[0] + size[0] * random.between(1.1f - 0.2f * wide, 1.1f + 0.2f * wide),
                        mesh.box_max[1] + 2 * size[1],
                        mesh.box_min[2] + size[2] * random.between(0.6f - 0.2f * wide, 0.6f + 0.2f * wide)};
    Segment s{{from[0], from[1], from[2]}, 0, {}, 1};
    for (int a = 0; a < 3; ++a) s.direction[a] = to[a] - from[a];
    segments.push_back({s, 1});
  }
  return in_order(std::move(segments));
}

Demand demand_of(const PreparedMesh& mesh, size_t count = 4000, uint64_t seed = 1) {
  return {{mesh.geometry_hash, shadow_rays(mesh, count, seed)}};
}

BakeOptions options_for(const Demand& demand, Method method = Method::hybrid, uint32_t depth = 6) {
  BakeOptions options;
  options.method = method;
  options.depth = depth;
  options.demand = &demand;
  options.budget_bytes = uint64_t{1} << 20;
  return options;
}

BakedObject must_bake_for(const PreparedMesh& mesh, const BakeOptions& options) {
  auto baked = bake(mesh, options);
  EXPECT_TRUE(baked.ok()) << baked.error().message;
  return baked ? std::move(*baked) : BakedObject();
}

CellClass class_at(const BakedObject& object, const LineCell& line) { return class_of(object.tree(), line); }

TEST(BakeForDemand, GivesTheSameBytesOnAnyNumberOfThreads) {
  const PreparedMesh mesh = foliage();
  const Demand demand = demand_of(mesh, 1000);
  for (const uint64_t budget : {330'000u}) {
    std::vector<std::vector<std::byte>> files;
    for (const unsigned threads : {1u, 3u}) {
      BakeOptions options = options_for(demand, Method::hybrid, 8);
      options.threads = threads, options.budget_bytes = budget;
      const BakedObject baked = must_bake_for(mesh, options);
      files.push_back(sidecar_bytes({&baked}));
    }
    EXPECT_EQ(files[0], files[1]);
  }
}

TEST(BakeForDemand, KeepsToItsBudgetAndAnswersMoreWithMore) {
  const PreparedMesh mesh = foliage();
  const Demand demand = demand_of(mesh, 20000);
  double share = 0;
  for (const uint64_t budget : {300'000u, 340'000u, 400'000u}) {
    BakeOptions options = options_for(demand, Method::hybrid, 8);
    options.budget_bytes = budget;
    const BakedObject baked = must_bake_for(mesh, options);
    EXPECT_LE(sidecar_bytes({&baked}).size(), budget);
    EXPECT_GE(sidecar_bytes({&baked}).size(), budget - budget / 20) << "equal blocks are not reckoned twice";
    EXPECT_EQ(baked.cells_demoted, 0u) << "what does not fit is not divided";
    EXPECT_GT(baked.demand->share(), share);
    share = baked.demand->share();
  }
}

// What a bake of all cells would say of a line: the recursion, from the root, without any tree.
uint32_t ordinary_class(const CellClassifier& classifier, uint32_t depth, const LineCell& line, Workspace& workspace) {
  uint32_t value = kDeeper;
  for (uint32_t level = 0; value == kDeeper; ++level) {
    const uint32_t up = 8 - level;
    value = classifier.classify({line.pair, level, line.s >> up, line.t >> up, line.u >> up, line.v >> up},
                                level == depth, workspace);
  }
  return value;
}

TEST(BakeForDemand, WhatIsAskedHasTheClassOfAnOrdinaryBake) {
  const PreparedMesh mesh = foliage();
  const Demand demand = {{mesh.geometry_hash, shadow_rays(mesh, 1000, 1, 0.25f)}};
  const GridMesh grid(mesh);
  const auto tracer = trace_in_grid(grid);
  const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
  std::array<size_t, 4> classes{};
  for (const Method method : {Method::proven, Method::hybrid, Method::sampled})
    for (const uint32_t depth : kDepths) {
      BakeOptions options = options_for(demand, method, depth);
      options.budget_bytes = uint64_t{1} << 20;
      const BakedObject asked = must_bake_for(mesh, options);
      const ChosenClassifier classifier = make_classifier(grid, *tracer, options);
      Workspace workspace;
      std::array<size_t, 4> compared{};
      for (const AskedSegment& s : demand.at(mesh.geometry_hash)) {
        const LineCell line = locate(frame, s.segment);
        if (is_kept_out(s.segment) || place_of(line, 0, 1) != Place::pierces) continue;
        const auto value = static_cast<uint32_t>(class_at(asked, line));
        ASSERT_EQ(value, ordinary_class(*classifier.cells, depth, line, workspace));
        ++compared[value];
      }
      EXPECT_GT(std::reduce(compared.begin(), compared.end()), 500u);
      for (size_t c = 0; c < 4; ++c) classes[c] += compared[c];
    }
  for (const uint32_t c : {kClear, kUnclassified}) EXPECT_GT(classes[c], 0u) << c;
}

TEST(BakeForDemand, NoProvenAnswerIsWrongAtDepthEight) {
  for (SourceMesh& source : std::array{leaves(60), sphere(), cube()}) {
    const PreparedMesh mesh = prepared(std::move(source));
    const Demand demand = demand_of(mesh, 20000);
    BakeOptions options = options_for(demand, Method::hybrid, 8);
    options.audit_lines = 30000, options.budget_bytes = 500'000;
    const BakedObject baked = must_bake_for(mesh, options);
    ASSERT_EQ(baked.record.depth, 8);
    TreeView proofs = baked.tree();
    proofs.answers = answer_table(Trust::proofs);
    const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
    const Referee referee(mesh);
    size_t answered = 0;
    // Those of the demand, and others like them.
    for (const uint64_t seed : {1, 2})
      for (const AskedSegment& s : shadow_rays(mesh, 20000, seed)) {
        const Visibility answer = classify(frame, proofs, proofs.shape, s.segment);
        if (answer == Visibility::unclassified) continue;
        ++answered;
        EXPECT_EQ(answer == Visibility::blocked, referee.occluded(s.segment)) << replayable(s.segment);
      }
    EXPECT_GT(answered, 4000u);
  }
}

TEST(BakeForDemand, WithoutABudgetTheTreeHasOneOfItsOwn) {
  if (kSanitized) GTEST_SKIP() << kOnceIsEnough;
  const auto bake_without = [](const PreparedMesh& mesh) {
    const Demand demand = demand_of(mesh, 100'000);
    BakeOptions options = options_for(demand, Method::sampled, 8);
    options.samples = 16, options.budget_bytes = 0;
    return must_bake_for(mesh, options);
  };
  const BakedObject full = bake_without(prepared(leaves(300)));
  EXPECT_LE(full.tree().bytes(), kDemandBudgetBytes);
  EXPECT_GT(full.tree().bytes(), kDemandBudgetBytes - kDemandBudgetBytes / 20);
  EXPECT_GT(bake_without(prepared(sphere(160, 320))).to_write().hierarchy.size(), kDemandBudgetBytes);
}

// Only a demand leaves cells above the deepest level statistically blocked.
TEST(Dag, HoldsStatisticallyBlockedCellsOfAnySize) {
  for (const uint32_t depth : {2, 5, 6, 7, 8}) {
    if (kSanitized && depth > 5) continue;
    const TreeShape shape = tree_shape(depth);
    Subtree subtree;
    subtree.bricks.assign(bricks_below_top(shape), kStatisticallyBlocked);
    DagBuilder dag(depth);
    for (uint32_t slot = 0; slot < shape.top_words(); ++slot) dag.append(subtree);
    const TreeArrays tree = dag.take();
    LineCell line{};
    line.pair = 7, line.s = 200, line.t = 3, line.u = 77, line.v = 130;
    EXPECT_EQ(class_of(tree.view(), line), CellClass::statistically_blocked);
    EXPECT_EQ(tree.view().brick_count, kUniformBlocks + 1);
  }
}

TEST(BakeForDemand, TheShareAnsweredIsWhatARendererCounts) {
  const PreparedMesh mesh = foliage();
  Demand demand = demand_of(mesh, 8000);
  for (AskedSegment& s : demand.begin()->second) s.weight = 1 + std::abs(s.segment.direction[0]);
  const BakedObject baked = must_bake_for(mesh, options_for(demand));
  const auto bytes = sidecar_bytes({&baked});
  const auto aligned = allocate_aligned(bytes.size());
  std::memcpy(aligned.data.get(), bytes.data(), bytes.size());
  const auto sidecar = Sidecar::open_buffer({aligned.data.get(), aligned.size});
  ASSERT_TRUE(sidecar.ok()) << sidecar.error().message;
  const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
  const Referee referee(mesh);
  double all = 0, answered = 0;
  uint64_t segments = 0, wrong = 0, kept = 0;
  for (const auto& [segment, weight] : demand.begin()->second) {
    kept += is_kept_out(segment);
    const LineCell line = locate(frame, segment);
    if (!is_kept_out(segment) || !line.hits || line.t_entry >= 1 || line.t_exit <= 0) continue;
    const Visibility answer = sidecar->object(0).classify(segment);
    ++segments, all += weight;
    if (answer == Visibility::unclassified) continue;
    answered += weight;
    wrong += (answer == Visibility::blocked) != referee.occluded(segment);
  }
  ASSERT_TRUE(baked.demand.has_value());
  EXPECT_EQ(baked.demand->segments, segments);
  EXPECT_EQ(baked.demand->wrong, wrong);
  EXPECT_DOUBLE_EQ(baked.demand->weight, all);
  EXPECT_DOUBLE_EQ(baked.demand->answered_weight, answered);
  EXPECT_GT(baked.demand->share(), 0.3);
  EXPECT_NEAR(static_cast<double>(kept) / 8000, 0.125, 0.02);
}

TEST(BakeForDemand, IsRightWhateverIsAsked) {
  const PreparedMesh mesh = foliage();
  FloatRandom random(9);
  std::vector<AskedSegment> segments;
  for (int i = 0; i < 3000; ++i) {
    Segment s{};
    for (float& x : s.origin) x = random.between(-3, 3);
    for (float& x : s.direction) x = random.between(-1, 1) * std::exp(random.between(-9, 9));
    s.t_min = random.between(-5, 1), s.t_max = random.below(3) == 0 ? std::numeric_limits<float>::infinity() : 2;
    segments.push_back({s, std::exp(random.between(-20, 40))});
  }
  const Demand demand = {{mesh.geometry_hash, in_order(std::move(segments))}};
  BakeOptions options = options_for(demand, Method::proven);
  options.audit_lines = 100000;
  const BakedObject baked = must_bake_for(mesh, options);
  EXPECT_EQ(baked.audit->sum(false).all_wrong() + baked.audit->sum(true).all_wrong(), 0u);
}

TEST(BakeForDemand, WithoutTimeIsCoarseAndRight) {
  const PreparedMesh mesh = foliage();
  const Demand demand = demand_of(mesh, 20000);
  BakeOptions options = options_for(demand, Method::proven);
  options.budget_seconds = 0.02, options.audit_lines = 30000;
  const BakedObject hurried = must_bake_for(mesh, options);
  EXPECT_TRUE(hurried.out_of_time);
  options.budget_seconds = 0;
  const BakedObject calm = must_bake_for(mesh, options);
  EXPECT_FALSE(calm.out_of_time);
  EXPECT_LT(hurried.demand->share(), calm.demand->share());
}

TEST(BakeForDemand, ItsDepthFollowsFromTheBytes) {
  const PreparedMesh mesh = foliage();
  const Demand demand = demand_of(mesh, 5000);
  uint32_t before = 0;
  for (const uint64_t budget : {16'000u, 100'000u, 500'000u}) {
    BakeOptions options = options_for(demand, Method::sampled, 0);
    options.budget_bytes = budget, options.samples = 16, options.hierarchy = false;
    const BakedObject baked = must_bake_for(mesh, options);
    EXPECT_LE(sidecar_bytes({&baked}).size(), budget);
    EXPECT_GT(baked.record.depth, before);
    before = baked.record.depth;
  }
  EXPECT_EQ(before, 7u) << "an eighth level answers too little";
}

TEST(BakeForDemand, ElsewhereItIsAsDeepAsItIsTold) {
  const PreparedMesh mesh = foliage();
  const Demand demand = demand_of(mesh);
  BakeOptions ordinary;
  ordinary.method = Method::proven, ordinary.depth = 4;
  BakeOptions options = options_for(demand, Method::proven, 6);
  options.budget_bytes = uint64_t{2} << 20;
  const auto coarse = bake(mesh, options);
  options.depth_elsewhere = 4;
  const auto deep = bake(mesh, options), everywhere = bake(mesh, ordinary);
  ASSERT_TRUE(coarse && deep && everywhere) << (deep ? "" : deep.error().message);
  const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
  const auto answer = [&](const BakedObject& object, const Segment& s) {
    const TreeView tree = object.tree();
    return classify(frame, tree, tree.shape, s);
  };
  FloatRandom random(9);
  size_t decided = 0, missed_by_coarse = 0;
  for (int i = 0; i < 20000; ++i) {
    Segment s{{}, 0, {}, 1};
    for (size_t a = 0; a < 3; ++a) {
      const float size = mesh.box_max[a] - mesh.box_min[a], middle = mesh.box_min[a] + 0.5f * size;
      s.origin[a] = middle + size * random.between(-2, 2);
      s.direction[a] = 2 * (middle + size * random.between(-0.5f, 0.5f) - s.origin[a]);
    }
    const Visibility expected = answer(*everywhere, s);
    if (expected == Visibility::unclassified) continue;
    ++decided;
    EXPECT_EQ(answer(*deep, s), expected);
    missed_by_coarse += answer(*coarse, s) == Visibility::unclassified;
  }
  EXPECT_GT(decided, 5000u);
  EXPECT_GT(missed_by_coarse, decided / 20);

  options.budget_bytes = uint64_t{300} << 10;
  const auto too_small = bake(mesh, options);
  ASSERT_FALSE(too_small);
  EXPECT_EQ(too_small.error().code, ErrorCode::usage);
  EXPECT_NE(too_small.error().message.find("depth 4 everywhere"), std::string::npos) << too_small.error().message;
  options.demand = nullptr;
  EXPECT_FALSE(bake(mesh, options));
}

TEST(BakeForDemand, WhatCannotBeBakedForSaysSo) {
  const PreparedMesh mesh = foliage();
  const auto fault = [&](const BakeOptions& options) {
    const auto baked = bake(mesh, options);
    EXPECT_FALSE(baked.ok());
    EXPECT_EQ(baked.ok() ? ErrorCode::runtime : baked.error().code, ErrorCode::usage);
    return baked.ok() ? std::string() : baked.error().message;
  };
  const Demand other = demand_of(prepared(cube()));
  EXPECT_NE(fault(options_for(other)).find("asks nothing of it"), std::string::npos);
  Demand outside = demand_of(mesh, 10);
  for (AskedSegment& s : outside.begin()->second) s.segment.t_max = 1e-3f, s.segment.origin[1] -= 5;
  EXPECT_NE(fault(options_for(outside)).find("none of the demand's 10 segments enters its box"), std::string::npos);
  const Demand demand = demand_of(mesh);
  EXPECT_NE(fault(options_for(demand, Method::hybrid, 1)).find("2 to 8"), std::string::npos);
  EXPECT_NE(fault(options_for(demand, Method::none)).find("none"), std::string::npos);
  BakeOptions small = options_for(demand);
  small.budget_bytes = 10000;
  EXPECT_NE(fault(small).find("more than the budget"), std::string::npos);
}

// A bake for more than an earlier one was for: it classifies less, and says the same of what was known.
TEST(BakeForDemand, WhatIsKnownIsNotClassifiedAgain) {
  const PreparedMesh mesh = foliage();
  const Demand first = demand_of(mesh, 4000, 1), second = demand_of(mesh, 4000, 2);
  const std::array<Demand, 2> demands = {first, second};
  const Demand both = merge(demands);
  for (const Method method : {Method::proven, Method::hybrid})
    for (const uint32_t depth : kSanitized ? std::vector{4u, 8u} : std::vector{4u, 6u, 8u}) {
      BakeOptions options = options_for(first, method, depth);
      options.budget_bytes = 320'000;
      const BakedObject before = must_bake_for(mesh, options);
      options.demand = &both, options.budget_bytes = 360'000;
      const BakedObject anew = must_bake_for(mesh, options);
      options.known = {before.record, before.tree()};
      const BakedObject more = must_bake_for(mesh, options);
      EXPECT_GT(before.cells_classified, 0u);
      EXPECT_LT(more.cells_classified, anew.cells_classified - before.cells_classified / 4) << depth;
      EXPECT_GE(more.demand->share(), anew.demand->share() - 0.01);
      EXPECT_LE(sidecar_bytes({&more}).size(), options.budget_bytes);
      const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
      for (const AskedSegment& s : first.begin()->second) {
        const LineCell line = locate(frame, s.segment);
        if (place_of(line, 0, 1) != Place::pierces) continue;
        const CellClass old = class_at(before, line), now = class_at(more, line);
        if (now != CellClass::unclassified && (old == CellClass::clear || old == CellClass::blocked)) {
          ASSERT_EQ(old, now);
        }
      }
      // Nothing new is asked: nothing but the bytes could change.
      options.known = {more.record, more.tree()};
      const BakedObject again = must_bake_for(mesh, options);
      EXPECT_LT(again.cells_classified, more.cells_classified);
      // Only part of it is asked: the rest stays.
      options.demand = &second;
      const BakedObject part = must_bake_for(mesh, options);
      EXPECT_GE(judge_demand(mesh, part.record, part.tree(), first.begin()->second)->share(),
                0.95 * before.demand->share());
    }
}

TEST(BakeForDemand, CellsOfOtherStatisticsAreNotKnown) {
  const PreparedMesh mesh = foliage();
  const Demand demand = demand_of(mesh, 500);
  for (const Method method : {Method::hybrid, Method::sampled}) {
    BakeOptions options = options_for(demand, method, 4);
    options.samples = 256;
    const BakedObject before = must_bake_for(mesh, options);
    options.known = {before.record, before.tree()};
    options.samples = 81;
    const BakedObject other = must_bake_for(mesh, options);
    options.known.reset();
    EXPECT_EQ(other.cells_classified, must_bake_for(mesh, options).cells_classified);
  }
}

TEST(BakeForDemand, StopsWhenAsked) {
  const PreparedMesh mesh = foliage();
  const Demand demand = demand_of(mesh);
  BakeOptions options = options_for(demand);
  bool dividing = false;
  options.on_pass = [&](BakePass pass) { dividing = pass == BakePass::divide; };
  options.stop = [&] { return dividing; };
  const auto baked = bake(mesh, options);
  ASSERT_FALSE(baked.ok());
  EXPECT_NE(baked.error().message.find("stopped"), std::string::npos);
}

}  // namespace
}  // namespace vcd::test
