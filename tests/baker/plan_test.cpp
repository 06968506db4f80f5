#include <gtest/gtest.h>

#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
using namespace baker;
namespace {

BakeOptions automatic(Method method = Method::proven) {
  BakeOptions options = proven(0);
  options.method = method;
  return options;
}

uint64_t file_bytes(const BakedObject& object) { return sidecar_bytes({&object}).size(); }

TEST(Plan, IsTheSameEachTime) {
  const PreparedMesh mesh = *prepare(leaves(300));
  const Plan a = *plan(mesh, automatic()), b = *plan(mesh, automatic());
  EXPECT_EQ(a.depth, b.depth);
  for (size_t i = 0; i < a.forecasts.size(); ++i) {
    EXPECT_EQ(a.forecasts[i].bytes, b.forecasts[i].bytes);
    EXPECT_EQ(a.forecasts[i].resolved, b.forecasts[i].resolved);
    EXPECT_EQ(a.forecasts[i].resolved_shadow, b.forecasts[i].resolved_shadow);
  }
}

TEST(Plan, ForecastsBytesWithinAFactorOfTwoAndWhatIsResolved) {
  for (const SourceMesh& source : {sphere(), leaves(300)}) {
    const PreparedMesh mesh = *prepare(SourceMesh(source));
    const Plan forecast = *plan(mesh, automatic());
    for (uint32_t depth = 3; depth <= (kSanitized ? 3 : 5); ++depth) {
      const auto baked = bake(mesh, proven(depth));
      ASSERT_TRUE(baked.ok());
      const DepthForecast& f = forecast.forecasts[depth - 1];
      EXPECT_LT(static_cast<double>(f.bytes), 2.0 * static_cast<double>(baked->bytes_before_demotion))
          << source.name << depth;
      EXPECT_GT(2.0 * static_cast<double>(f.bytes), static_cast<double>(baked->bytes_before_demotion))
          << source.name << depth;
      const double resolved =
          1 - static_cast<double>(baked->record.cells[2]) / static_cast<double>(tree_shape(depth).cells());
      EXPECT_NEAR(f.resolved, resolved, 0.05) << source.name << depth;
    }
  }
}

TEST(Plan, GoesDeeperWithALargerBudgetAndKeepsIt) {
  if (kSanitized) GTEST_SKIP() << kOnceIsEnough;
  const PreparedMesh mesh = *prepare(sphere());
  uint32_t before = 0;
  for (uint64_t kilobytes : {60, 400, 1500}) {
    BakeOptions options = automatic();
    options.budget_bytes = kilobytes << 10;
    const auto baked = bake(mesh, options);
    ASSERT_TRUE(baked.ok());
    EXPECT_LE(file_bytes(*baked), options.budget_bytes);
    EXPECT_GE(baked->record.depth, before);
    before = baked->record.depth;
  }
  EXPECT_EQ(before, 5);
}

TEST(Plan, KnowsWhatIsNotWorthIt) {
  if (kSanitized) GTEST_SKIP() << kOnceIsEnough;
  for (const SourceMesh& source : {cube(), triangle()}) {
    const auto baked = bake(*prepare(SourceMesh(source)), automatic());
    ASSERT_TRUE(baked.ok());
    EXPECT_EQ(static_cast<Method>(baked->record.method), Method::none);
    EXPECT_EQ(baked->plan->depth, 0u);
    EXPECT_FALSE(baked->plan->reason.empty());
    EXPECT_LT(file_bytes(*baked), 6000u);
  }
  EXPECT_NE(static_cast<Method>(bake(*prepare(sphere()), automatic())->record.method), Method::none);
}

TEST(Plan, RefusesABudgetThatADepthCannotKeep) {
  BakeOptions options = proven(5);
  options.budget_bytes = 100 << 10;  // the top table alone takes 240 KiB
  EXPECT_EQ(bake(*prepare(sphere()), options).error().code, ErrorCode::usage);
}

TEST(Budget, OfSecondsEndsInAValidTreeHoweverShort) {
  const PreparedMesh mesh = *prepare(leaves(300));
  for (double seconds : {1e-6, 0.3}) {
    BakeOptions options = proven(6);
    options.budget_seconds = seconds;
    const auto baked = bake(mesh, options);
    ASSERT_TRUE(baked.ok());
    EXPECT_TRUE(baked->out_of_time);
    const AuditReport report = audit(mesh, answers_of(baked->record, baked->tree()), no_answers(), {.lines = 9000});
    EXPECT_EQ(report.sum(false).all_wrong() + report.sum(true).all_wrong(), 0u);
    std::vector<Finding> findings;
    EXPECT_TRUE(read_sidecar(sidecar_bytes({&*baked}), CheckLevel::canonical, findings).has_value());
  }
}

}  // namespace
}  // namespace vcd::test
