// A scene of instances on this machine: times of shadow rays with its sidecars and without.
#pragma once

#include <string>
#include <vector>

#include <vcd/baker/ingest.h>

#include "common/program.h"
#include "render/world.h"

namespace vcd::bench {

struct InstancesOptions {
  std::string scene;                  // as parse_scene_request() reads it
  std::vector<std::string> sidecars;  // of all its meshes
  baker::IngestOptions ingest;        // for meshes that none of them has
  bool quiet = false;
  size_t points = 3000;  // bundles of 128 shadow rays, about
  int repetitions = 7;
  tools::OutputFormat format = tools::OutputFormat::text;
};

// The scene that the options name. Errors: usage, and those of load_world().
Result<render::World> world_of(const InstancesOptions& options);

// Prints what it measured; returns the exit code.
int run_instances(const InstancesOptions& options);

}  // namespace vcd::bench
