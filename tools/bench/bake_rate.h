// How much of a bake's time is Embree's.
#pragma once

#include <cstdint>

#include <vcd/baker/prepare.h>
#include <vcd/format/error.h>

#include "timing.h"

namespace vcd {

struct BakeRateOptions {
  uint32_t depth = 5;
  uint32_t samples = 256;
  uint32_t top_cells = 200;  // random cells of level 3, each classified down to depth
};

struct BakeRate {
  uint64_t rays = 0;       // that the classification traced
  Timing classification;   // the baker's own recursion, one thread
  Timing bare16;           // rtcOccluded16 on the very same rays, sixteen at a time, in the same order
};

Result<BakeRate> measure_bake_rate(const PreparedMesh& mesh, const BakeRateOptions& options, int repetitions);

}  // namespace vcd
