// The sweeps of `vc-bench stability`, small: wherever other methods fail, a proof or a hierarchy never does.
#include "bench/stability.h"

#include <gtest/gtest.h>

namespace vcd::test {

using namespace bench;

namespace {

class Stability : public testing::TestWithParam<size_t> {};

TEST_P(Stability, NoProofAndNoHierarchyIsWrongAnywhere) {
  StabilitySweep sweep = stability_sweeps(true)[GetParam()];
  for (StabilitySweep::Point& p : sweep.points) p.rays /= 4;
  uint64_t visited = 0, resolved = 0, sampled_wrong = 0, embree_wrong = 0, refused = 0, without_hierarchy = 0,
           by_horizons = 0;
  run_sweep(sweep, {.depth = 3}, [&](size_t i, const StabilityPoint& p) {
    ++visited;
    EXPECT_EQ(p.counts[0].wrong, 0u) << sweep.title << ": " << sweep.points[i].x;
    EXPECT_EQ(p.horizons.wrong, 0u) << sweep.title << ": " << sweep.points[i].x;
    by_horizons += p.horizons.resolved;
    EXPECT_EQ(p.wrong_proven, 0u) << sweep.title << ": " << sweep.points[i].x;
    EXPECT_EQ(p.counts[kHierarchyMethod].wrong, 0u) << sweep.title << ": " << sweep.points[i].x;
    EXPECT_EQ(p.counts[kHierarchyMethod].resolved, p.no_hierarchy.empty() ? p.rays : 0);
    without_hierarchy += p.refused.empty() && !p.no_hierarchy.empty();
    refused += !p.refused.empty();
    resolved += p.counts[0].resolved;
    sampled_wrong += p.counts[2].wrong;
    embree_wrong += p.counts[kEmbreeMethod].wrong;
  });
  EXPECT_EQ(by_horizons > 100, sweep.id.starts_with("self-")) << by_horizons;
  EXPECT_EQ(visited, sweep.points.size());
  EXPECT_EQ(refused, sweep.id == "scale" ? 1u : 0u);      // 1e30 is beyond 2^100
  EXPECT_EQ(without_hierarchy > 0, sweep.id == "scale");  // its coordinates have a range
  // The sweeps go where it hurts, and the referee sees it.
  if (sweep.id == "slivers") {
    EXPECT_GT(sampled_wrong, 100u);
  } else if (!sweep.id.starts_with("self-")) {
    EXPECT_GT(resolved, 500u);
  }
  if (sweep.id == "segments" || sweep.id == "meshes") {
    EXPECT_GT(embree_wrong, 10u);
  }
}

TEST(StabilityForSegments, DepthEightIsAsRight) {
  StabilitySweep sweep = stability_sweeps(true)[5];
  ASSERT_EQ(sweep.id, "segments");
  sweep.points = {sweep.points[0]};  // along an axis
  run_sweep(sweep, {.depth = 8, .for_segments = true, .budget_bytes = 400'000}, [&](size_t, const StabilityPoint& p) {
    EXPECT_EQ(p.counts[0].wrong, 0u);
    EXPECT_EQ(p.wrong_proven, 0u);
    EXPECT_GT(p.counts[0].resolved, p.rays / 2);
  });
}

INSTANTIATE_TEST_SUITE_P(Sweeps, Stability, testing::Range(size_t{0}, stability_sweeps(true).size()),
                         [](const auto& instance) {
                           std::string name = stability_sweeps(true)[instance.param].id;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace vcd::test
