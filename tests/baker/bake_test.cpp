#include <vcd/baker/bake.h>

#include <algorithm>
#include <atomic>
#include <random>

#include <gtest/gtest.h>

#include <vcd/baker/audit.h>
#include <vcd/baker/measure.h>
#include <vcd/baker/referee.h>
#include <vcd/baker/sampled.h>

#include "audit/audit_object.h"
#include "classify/sampled_cells.h"
#include "octree/octree.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/trees.h"

namespace vcd::test {
using namespace baker;
namespace {

TEST(SampledClassifier, SamplesEveryStratumOnce) {
  const PreparedMesh mesh = *prepare(cube());
  const auto tracer = Tracer::build(positions_in_grid(mesh), mesh.triangles);
  for (uint32_t samples : {16u, 81u, 256u}) {
    const SampledClassifier classifier(*tracer, samples, 0);
    const uint32_t strata = samples == 16 ? 2 : samples == 81 ? 3 : 4;
    const Cell cell = {7, 2, 1, 3, 0, 2};  // faces 1 (x max) and 4 (z min)
    std::vector<int> hit(samples);
    for (uint32_t i = 0; i < samples; ++i) {
      RTCRay16 ray;
      classifier.fill(cell, i, 1, 8, ray);
      const float s = ray.org_y[0] / 64 - 1, t = ray.org_z[0] / 64 - 3;
      const float u = (ray.org_x[0] + ray.dir_x[0]) / 64, v = (ray.org_y[0] + ray.dir_y[0]) / 64 - 2;
      EXPECT_EQ(ray.org_x[0], 256.0f);
      EXPECT_NEAR(ray.org_z[0] + ray.dir_z[0], 0, 1e-4);
      uint32_t stratum = 0;
      for (float x : {s, t, u, v}) {
        ASSERT_GE(x, -1e-5f);
        ASSERT_LT(x, 1 + 1e-5f);
        stratum = stratum * strata +
                  std::min(static_cast<uint32_t>(std::max(x, 0.0f) * static_cast<float>(strata)), strata - 1);
      }
      ++hit[stratum];
    }
    EXPECT_EQ(std::count(hit.begin(), hit.end(), 1), samples);
  }
}

// What the recursion says of a cell of the deepest level, asked from the root without any tree.
uint32_t class_of(const CellSource& source, const Cell& deepest) {
  Workspace workspace;
  for (uint32_t level = 0; level <= source.depth; ++level) {
    const uint32_t up = deepest.level - level;
    const uint32_t value = source.classify(
        {deepest.pair, level, deepest.s >> up, deepest.t >> up, deepest.u >> up, deepest.v >> up}, workspace);
    if (value != kDeeper) return value;
  }
  return 2;
}

TEST(Octree, HoldsWhatTheRecursionSaysAtEveryDepth) {
  const PreparedMesh mesh = *prepare(leaves(3));
  const auto tracer = Tracer::build(positions_in_grid(mesh), mesh.triangles);
  const SampledCells classifier(SampledClassifier(*tracer, 16, 0));
  for (uint32_t depth = 1; depth <= 6; ++depth) {
    const CellSource source{classifier, depth};
    const auto octree = build_octree(source, 2, [](uint64_t, uint64_t, uint64_t) {});
    ASSERT_TRUE(octree.has_value());
    const TreeView tree = octree->tree.view();
    std::mt19937 random(depth);
    const uint32_t levels = depth, side = 1u << levels;
    for (int i = 0; i < 20000; ++i) {
      const Cell cell = {static_cast<uint32_t>(random() % kFacePairs), levels,
                         static_cast<uint32_t>(random() % side),       static_cast<uint32_t>(random() % side),
                         static_cast<uint32_t>(random() % side),       static_cast<uint32_t>(random() % side)};
      LineCell line{};
      const uint32_t up = 8 - levels;
      line.pair = cell.pair, line.s = cell.s << up, line.t = cell.t << up, line.u = cell.u << up, line.v = cell.v << up;
      ASSERT_EQ(static_cast<uint32_t>(class_of(tree, line)), class_of(source, cell)) << depth;
    }
  }
}

// The same for the layouts that would take too long to bake whole: one subtree of depth 7 and 8.
TEST(Octree, HoldsWhatTheRecursionSaysInTheDeepestLayouts) {
  const PreparedMesh mesh = *prepare(leaves(200));
  const auto tracer = Tracer::build(positions_in_grid(mesh), mesh.triangles);
  const SampledCells classifier(SampledClassifier(*tracer, 16, 0));
  Workspace workspace;
  for (uint32_t depth : {7u, 8u}) {
    const CellSource source{classifier, depth};
    const TreeShape shape = tree_shape(depth);
    const Cell top = {5, 3, 3, 4, 4, 3};
    DagBuilder builder(depth);
    const uint32_t slot = top.pair << 12 | row_major(top.s, top.t, top.u, top.v, 0, 3);
    Subtree clear;
    clear.bricks.assign(size_t{1} << (4 * (depth - 5)), 0);
    for (uint32_t i = 0; i < shape.top_words(); ++i)
      builder.append(i == slot ? classify_subtree(source, top, kDeeper, workspace) : clear);
    const TreeArrays arrays = builder.take();
    const TreeView tree = arrays.view();
    std::mt19937 random(depth);
    const uint32_t below = depth - 3, side = 1u << below;
    for (int i = 0; i < 5000; ++i) {
      const auto deepen = [&](uint32_t c) { return c << below | static_cast<uint32_t>(random() % side); };
      const Cell cell = {top.pair, depth, deepen(top.s), deepen(top.t), deepen(top.u), deepen(top.v)};
      uint32_t expected = kDeeper;
      for (uint32_t level = 4; level <= depth && expected == kDeeper; ++level) {
        const uint32_t up = depth - level;
        expected =
            source.classify({cell.pair, level, cell.s >> up, cell.t >> up, cell.u >> up, cell.v >> up}, workspace);
      }
      const uint32_t up = 8 - depth;
      LineCell line{};
      line.pair = cell.pair, line.s = cell.s << up, line.t = cell.t << up, line.u = cell.u << up, line.v = cell.v << up;
      ASSERT_EQ(static_cast<uint32_t>(class_of(tree, line)), expected) << depth;
    }
  }
}

TEST(Bake, GivesTheSameBytesForAnyNumberOfThreadsAndAnyOrder) {
  BakeOptions one = quick(5), two = quick(5), many = quick(5);
  one.threads = 1;
  two.threads = 2;
  many.threads = 7;
  SourceMesh reordered = leaves(40);
  std::reverse(reordered.triangles.begin(), reordered.triangles.end());
  const BakedObject a = must_bake(leaves(40), one), b = must_bake(leaves(40), two), c = must_bake(reordered, many);
  const auto bytes = sidecar_bytes({&a});
  EXPECT_EQ(bytes, sidecar_bytes({&b}));
  EXPECT_EQ(bytes, sidecar_bytes({&c}));
}

TEST(Bake, SeedChangesTheSamplesOnly) {
  BakeOptions other = quick(4);
  other.seed = 0x123456789;
  const BakedObject a = must_bake(sphere(), quick(4)), b = must_bake(sphere(), other);
  EXPECT_EQ(a.record.geometry_hash, b.record.geometry_hash);
  EXPECT_NE(sidecar_bytes({&a}), sidecar_bytes({&b}));
}

TEST(Bake, RefusesOptionsOutOfRange) {
  for (uint32_t depth : {9u, 1000u}) EXPECT_EQ(bake(*prepare(cube()), quick(depth)).error().code, ErrorCode::usage);
  EXPECT_EQ(bake(*prepare(cube()), quick(3, 64)).error().code, ErrorCode::usage);
}

TEST(Bake, StopsWhenAskedTo) {
  BakeOptions options = quick(8);  // hours of work
  std::atomic<bool> stop = false;
  options.progress = [&](const BakeProgress& p) { stop = p.rays > 0; };
  options.stop = [&] { return stop.load(); };
  EXPECT_FALSE(bake(*prepare(leaves(40)), options).ok());
}

TEST(Bake, ProgressGrowsToTheWhole) {
  BakeOptions options = quick(4);
  double last = 0;
  options.progress = [&](const BakeProgress& p) {
    EXPECT_GE(p.fraction, last);
    last = p.fraction;
  };
  EXPECT_TRUE(bake(*prepare(leaves(40)), options).ok());
  EXPECT_EQ(last, 1);
}

TEST(Bake, EmbedsTheGeometryBitForBit) {
  for (SourceMesh mesh : {cube(), sphere(), leaves(100), triangle()}) {
    const PreparedMesh expected = *prepare(SourceMesh(mesh));
    const std::vector<std::byte> draco = encode_geometry(expected);
    auto decoded = decode_geometry(draco);
    ASSERT_TRUE(decoded.ok());
    const PreparedMesh actual = *prepare(std::move(*decoded));
    EXPECT_EQ(actual.positions, expected.positions);
    EXPECT_EQ(actual.geometry_hash, expected.geometry_hash);
  }
}

TEST(Audit, FindsAWrongCell) {
  const PreparedMesh mesh = *prepare(sphere());
  const BakedObject baked = must_bake(sphere(), quick(4, 256));
  AuditOptions options;
  options.lines = 150000;
  const TreeView good = baked.tree();
  const auto before = audit(mesh, answers_of(baked.record, good), no_answers(), options);
  // The same tree with every top word that says clear made to say blocked.
  std::vector<uint32_t> top(good.top, good.top + good.shape.top_bytes() / 4);
  for (uint32_t i = 0; i < good.shape.top_words(); ++i)
    if (top[i] == 0) top[i] = 1;
  TreeView bad = good;
  bad.top = top.data();
  const auto after = audit(mesh, answers_of(baked.record, bad), answers_of(baked.record, good), options);
  EXPECT_LT(before.counts[0].wrong[1], 50u);
  EXPECT_GT(after.counts[0].wrong[1], 1000u);
  ASSERT_FALSE(after.contradictions.empty());
  const Referee referee(mesh);
  for (const Contradiction& c : after.contradictions)
    EXPECT_NE(referee.occluded(c.segment), c.promised == Visibility::blocked);
  // What the good tree says is called proven here: wrong answers of the bad one alone are not.
  EXPECT_LT(after.counts[0].wrong_proven, 50u);
}

// The tree with every clear cell made blocked.
TreeArrays with_clear_made_blocked(const TreeView& tree, uint32_t depth) {
  TreeArrays wrong = arrays_of(tree, depth);
  for (uint32_t& word : wrong.bricks) word |= ~(word | word >> 1) & 0x55555555u;
  return wrong;
}

TEST(Audit, OfAWrongProofFailsTheBakeAndGivesTheLines) {
  const PreparedMesh mesh = *prepare(sphere());
  const BakedObject baked = must_bake(sphere(), proven(3));
  ASSERT_TRUE(audit_object(mesh, baked.record, baked.tree(), {.lines = 9000}).ok());
  const TreeArrays wrong = with_clear_made_blocked(baked.tree(), 3);
  const auto report = audit_object(mesh, baked.record, wrong.view(), {.lines = 9000});
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::difference);
  const std::string& message = report.error().message;
  const size_t at = message.find("--segment=");
  ASSERT_NE(at, std::string::npos) << message;
  Segment segment{};
  ASSERT_TRUE(parse_segment(message.substr(at + 10, message.find(' ', at) - at - 10), segment)) << message;
  EXPECT_FALSE(Referee(mesh).occluded(segment));  // although the tree says that it is blocked
}

// Only proofs are promises: a sampled tree, and the statistical cells of a hybrid one, may be wrong.
TEST(Audit, OfWrongStatisticsIsAResult) {
  const PreparedMesh mesh = *prepare(sphere());
  const BakedObject baked = must_bake(sphere(), quick(3));
  const TreeArrays wrong = with_clear_made_blocked(baked.tree(), 3);
  const auto report = audit_object(mesh, baked.record, wrong.view(), {.lines = 9000});
  ASSERT_TRUE(report.ok());
  EXPECT_GT(report->sum(false).wrong[1], 100u);
  EXPECT_EQ(report->sum(false).wrong_proven, 0u);
}

TEST(Bake, AuditsWhenAskedToAndRecordsWhatItFound) {
  const PreparedMesh mesh = *prepare(sphere());
  BakeOptions options = quick(3);
  EXPECT_FALSE(bake(mesh, options)->audit.has_value());
  EXPECT_EQ(bake(mesh, options)->record.audit_lines[0], 0u);
  options.audit_lines = 9000;
  const auto baked = bake(mesh, options);
  ASSERT_TRUE(baked.ok() && baked->audit);
  const AuditReport expected = audit(mesh, answers_of(baked->record, baked->tree()), no_answers(), {.lines = 9000});
  for (bool aimed : {false, true}) {
    EXPECT_EQ(baked->record.audit_lines[aimed], expected.sum(aimed).segments);
    EXPECT_EQ(baked->record.audit_wrong[aimed], expected.sum(aimed).all_wrong());
    EXPECT_EQ(baked->audit->sum(aimed).all_wrong(), expected.sum(aimed).all_wrong());
  }
  EXPECT_GT(baked->record.audit_bound_95, 0);
}

TEST(Bake, NamesItsPassesInOrder) {
  BakeOptions options = quick(3);
  options.audit_lines = 900, options.budget_bytes = 100 << 20;
  std::vector<BakePass> passes;
  options.on_pass = [&](BakePass pass) { passes.push_back(pass); };
  ASSERT_TRUE(bake(*prepare(sphere()), options).ok());
  EXPECT_EQ(passes, (std::vector{BakePass::hierarchy, BakePass::trace, BakePass::classify, BakePass::demote,
                                 BakePass::clearances, BakePass::audit}));
}

TEST(Bake, StopsInItsAudit) {
  BakeOptions options = quick(2);
  options.audit_lines = 2'000'000'000;  // half an hour of work
  std::atomic<bool> auditing = false;
  options.on_pass = [&](BakePass pass) { auditing = pass == BakePass::audit; };
  options.stop = [&] { return auditing.load(); };
  EXPECT_FALSE(bake(*prepare(leaves(40)), options).ok());
}

TEST(BakeTime, OfAPartIsAboutThatOfTheWhole) {
  const PreparedMesh mesh = *prepare(leaves(100));
  BakeOptions options = quick(4);
  options.threads = 1;
  const auto whole = time_bake(mesh, options, 1), part = time_bake(mesh, options, 8);
  ASSERT_TRUE(whole.ok() && part.ok());
  EXPECT_EQ(whole->rays, bake(mesh, options)->rays);
  EXPECT_LT(part->rays, whole->rays / 2);
  EXPECT_GT(part->seconds, whole->seconds / 4);  // the machine may be shared
  EXPECT_LT(part->seconds, whole->seconds * 4);
}

TEST(Audit, DoesNotDependOnTheMeshsScale) {
  for (int exponent : {-90, -40, 0, 40, 90}) {
    SourceMesh mesh = sphere();
    for (Position& p : mesh.positions)
      for (float& x : p) x = std::ldexp(x, exponent);
    const PreparedMesh prepared = *prepare(SourceMesh(mesh));
    const BakedObject baked = must_bake(mesh, quick(3, 81));
    AuditOptions options;
    options.lines = 60000;
    const auto report = audit(prepared, answers_of(baked.record, baked.tree()), no_answers(), options);
    EXPECT_GT(report.counts[0].answered[1], 3000u) << exponent;
    EXPECT_LT(report.counts[0].wrong[0] + report.counts[0].wrong[1], 100u) << exponent;
  }
}

TEST(Tracer, TakesNegativeAndEmptyIntervals) {
  const PreparedMesh mesh = *prepare(cube());
  const auto tracer = Tracer::build(mesh.positions, mesh.triangles);
  EXPECT_TRUE(tracer->occluded({{0.5f, 0.4f, 2}, -1, {0, 0, 2}, 0}));
  EXPECT_FALSE(tracer->occluded({{0.5f, 0.4f, 2}, -0.4f, {0, 0, 2}, -0.1f}));
  EXPECT_FALSE(tracer->occluded({{0.5f, 0.4f, -1}, 1, {0, 0, 3}, 0}));
}

TEST(Audit, BoundsARate) {
  EXPECT_NEAR(upper_bound_95(0, 1000000), 2.9957e-6, 1e-9);  // ln 20
  EXPECT_NEAR(upper_bound_95(10, 1000), 16.962e-3, 1e-5);    // half the chi-square quantile of 22 degrees
  EXPECT_EQ(upper_bound_95(0, 0), 1);
  EXPECT_NEAR(lower_bound_95(1, 1000), 5.1293e-5, 1e-9);   // -ln 0.95
  EXPECT_NEAR(lower_bound_95(10, 1000), 5.4254e-3, 1e-7);  // half the chi-square quantile of 20 degrees
  EXPECT_EQ(lower_bound_95(0, 1000), 0);
  EXPECT_EQ(lower_bound_95(0, 0), 0);
  EXPECT_NEAR(lower_bound_95(100000, 1000000), 0.1, 6e-4);
}

}  // namespace
}  // namespace vcd::test
