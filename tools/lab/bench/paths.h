// The shadow rays of a path tracer on this machine: their times with sidecars and without.
#pragma once

#include "instances.h"

namespace vcd::bench {

struct PathsOptions : InstancesOptions {
  uint32_t bounces = 4;
  PathsOptions() { points = 100'000; }  // paths
};

// Prints what it measured; returns the exit code.
int run_paths(const PathsOptions& options);

}  // namespace vcd::bench
