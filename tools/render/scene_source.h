// The scene that a program is asked for: a generated one by its name, or mesh files.
#pragma once

#include <string>
#include <vector>

#include <vcd/scenes/generate.h>

#include <CLI/CLI.hpp>

#include "world.h"

namespace vcd {

struct SceneOptions {
  uint32_t level = 8;
  scenes::HairballOptions hairball;
  scenes::ForestOptions forest;
  char up = 'y';
  double turn_degrees = 0;
};

// --level, --strands, --segments, --sides, --instances, --species, --leaves, --up, --turn.
void add_scene_options(CLI::App& app, SceneOptions& options);

bool is_generated_scene(const std::string& name);  // sierpinski, hairball, forest

// What the arguments name: one generated scene, or mesh files, which stand together in the frame that they share.
// Errors: usage; those of ingest_isolated(), prepare() and build_world(). Notes of what a file left out are printed unless
// quiet.
Result<World> load_world(const std::vector<std::string>& names, const SceneOptions& options, bool quiet);

}  // namespace vcd
