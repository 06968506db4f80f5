// What a bake by each method costs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/program.h"
#include "traced_mesh.h"

namespace vcd::bench {

struct BakeTimeOptions {
  std::vector<uint32_t> depths = {5, 6, 7};
  uint32_t one_in = 40;  // of so many cells of the top table is classified
  unsigned threads = 1;
};

// Times bakes by proof, hybrid and by 256 samples, interleaved, and prints seconds, ratios and resolved shares. Returns
// the exit code.
int run_bake_time(const MeshToRead& mesh, const BakeTimeOptions& options, int repetitions, tools::OutputFormat format);

}  // namespace vcd::bench
