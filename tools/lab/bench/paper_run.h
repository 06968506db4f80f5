// The paper's Tables 1 and 2 for one scene after another, and what goes beyond them: every figure of the report.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <vcd/format/layout.h>

#include "render/renderer.h"
#include "render/scene_source.h"
#include "results.h"

namespace vcd::bench {

// A tree to bake of each scene.
struct Configuration {
  uint32_t depth;
  Method method;
  uint32_t samples;         // as BakeOptions has them
  bool for_demand = false;  // of the same picture with another seed; then the baker picks the depth

  // "5x256", "5xproven", "5xhybrid", "demandxproven", "demandxhybrid" and back; nothing if it is none of these.
  static std::optional<Configuration> parse(const std::string& text);
  std::string text() const;

  std::string id() const;  // of files and in the results
};

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
  int repetitions = 7;
  double budget_mb = 8;                    // of an object that is baked for a demand
  size_t most_recorded = size_t{1} << 21;  // of it
  uint64_t segments_of_kind = 1 << 16;     // to time, of each kind, at most
  bool quiet = false;
};

// Goes through all that `results` lacks, saving after each step; the steps are baking each tree, counting with each,
// timing them all, and timing segments by kind. A scene that fails leaves its error in the results and the others go
// on. Returns the exit code of each scene.
std::vector<int> run_paper(const PaperRunOptions& options, Results& results);

}  // namespace vcd::bench
