// How much of a bake's time is Embree's.
#pragma once

#include <cstdint>
#include <string>

#include "common/program.h"
#include "traced_mesh.h"

namespace vcd::bench {

struct BakeRateOptions {
  uint32_t depth = 5;
  uint32_t samples = 256;
  uint32_t top_cells = 200;  // random cells of level 3, each classified down to depth
};

// The baker's recursion below random cells, against bare rtcOccluded16 on the very rays that it traced. Prints what it
// measured; returns the exit code.
int run_bake_rate(const MeshToRead& mesh, const BakeRateOptions& options, int repetitions, tools::OutputFormat format);

}  // namespace vcd::bench
