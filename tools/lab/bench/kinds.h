// Shadow rays by how they lie to the box: what each of Embree's ways and each sidecar takes for them.
#pragma once

#include <vector>

#include "common/describe.h"
#include "render/census.h"
#include "render/recording.h"
#include "timing.h"

namespace vcd::bench {

struct SidecarVariant {
  std::string id;
  const std::vector<Object>* objects;
  render::ShadowWays ways;
};

// The bundles of a picture by the kind of their segments, each cut where the kind changes and thinned out evenly to
// about `most` segments a kind. The kinds of all segments of the recording are counted in `all`.
std::array<render::Recording, render::kSegmentKinds> split_by_kind(const render::World& world,
                                                                   const render::Recording& recording, uint64_t most,
                                                                   std::array<uint64_t, render::kSegmentKinds>& all);

// The entry of one kind in the report: every way of Embree's, and for every variant the look-up alone, all that its
// ways do for such segments, and the same with its own hierarchy instead of Embree's; interleaved, nanoseconds a
// segment, on one thread. judge: as Census has it; it learns.
tools::Json measure_kind(const render::World& world, render::SegmentKind kind, const render::Recording& bundles,
                         const std::vector<SidecarVariant>& variants, const render::TestCounter& counter,
                         EmbreeQuery truth, render::Judge* judge, int repetitions);

// Segments, answers, wrong answers and the 95 % bound of their share.
tools::Json describe_counts(const render::KindCounts& counts);
tools::Json describe_seconds(const Timing& timing, double scale);  // {"median", "minimum", "maximum"}

}  // namespace vcd::bench
