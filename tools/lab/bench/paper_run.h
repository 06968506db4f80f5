// The paper's Tables 1 and 2 for one scene after another, and what goes beyond them: every figure of the report.
#pragma once

#include <string>
#include <vector>

#include "configuration.h"
#include "render/renderer.h"
#include "render/scene_source.h"
#include "results.h"
#include "scene_bakes.h"

namespace vcd::bench {

struct SceneRequest {
  std::string name;                 // in the results, and of its files
  std::vector<std::string> source;  // for load_world()
  render::SceneOptions options;
};

// "[NAME=]SCENE|MESH[,KEY=VALUE]…": "forest,instances=1000", "killeroo=killeroo_loop1.ply,up=z". Errors: usage.
Result<SceneRequest> parse_scene_request(const std::string& text, const render::SceneOptions& defaults);

struct PaperRunOptions {
  std::vector<SceneRequest> scenes;
  std::vector<Configuration> configurations;
  render::RenderSettings render;
  BakesOfScene bakes;
  int repetitions = 7;
  uint64_t segments_of_kind = 1 << 16;  // to time, of each kind, at most
  size_t paths = 300'000;               // of a path tracer, whose shadow rays are timed: so many that caches are warm
  bool quiet = false;
};

// Goes through all that `results` lacks, saving after each step; the steps are baking each tree, counting with each,
// timing them all, timing segments by kind, and timing the
// shadow rays of a path tracer. A scene that fails leaves its error in the results and the others go
// on. Returns the exit code of each scene.
std::vector<int> run_paper(const PaperRunOptions& options, Results& results);

}  // namespace vcd::bench
