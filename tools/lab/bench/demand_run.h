// Sidecars that are baked for what a scene asks, asked by other cameras and under other lights.
#pragma once

#include <string>

#include <vcd/baker/ingest.h>

#include "common/program.h"
#include "render/renderer.h"

namespace vcd::bench {

struct DemandRunOptions {
  std::string scene;  // as parse_scene_request() reads it
  baker::IngestOptions ingest;
  std::string folder;  // for sidecars
  render::RenderSettings render;
  uint32_t depth = 5;    // of sidecars for any scene
  double budget_mb = 0;  // of an object, of bakes for a demand; 0: their default
  size_t most_recorded = size_t{1} << 21;
  uint64_t judged = 0;       // segments of further pictures, at least, to judge with each sidecar
  bool proven_only = false;  // no hybrid bakes
  bool quiet = false;
  int repetitions = 7;
  tools::OutputFormat format = tools::OutputFormat::text;
};

// Bakes sidecars for any scene, and for demands: of the scene's camera, of three cameras, and of the lights
// alone. Then asks each for pictures with another seed: of the same camera; turned by 30, 90 and 180 degrees; and with
// the lights turned by 30 degrees. Prints for each picture what the look-ups leave unclassified, wrong answers by exact
// arithmetic, and the time of shadow rays with the hierarchy behind the look-ups, against Embree's fastest ways.
// Returns the exit code.
int run_demand(const DemandRunOptions& options);

}  // namespace vcd::bench
