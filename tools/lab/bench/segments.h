// One sidecar on this machine: answers, shares and times of segments with and without it.
#pragma once

#include <string>

#include "common/program.h"
#include "traced_mesh.h"

namespace vcd::bench {

struct SegmentsOptions {
  MeshToRead mesh;  // as the sidecar says
  std::string sidecar;
  size_t object = 0;
  size_t points = 4000;
  int repetitions = 7;
  tools::OutputFormat format = tools::OutputFormat::text;
};

// Prints what it measured; returns the exit code.
int run_segments(const SegmentsOptions& options);

}  // namespace vcd::bench
