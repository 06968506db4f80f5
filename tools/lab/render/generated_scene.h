// The scenes that can be generated, by their names on the command line.
#pragma once

#include <string>

#include <vcd/format/error.h>
#include <vcd/scenes/generate.h>

#include <CLI/CLI.hpp>

namespace vcd::render {

struct GeneratedSceneOptions {
  uint32_t level = 8;
  scenes::HairballOptions hairball;
  scenes::ForestOptions forest;
};

// --level, --strands, --segments, --sides, --instances, --species, --leaves, and the seed under the flag given.
void add_generated_scene_options(CLI::App& app, GeneratedSceneOptions& options, const std::string& seed_flag);

bool is_generated_scene(const std::string& name);  // sierpinski, hairball, forest

// Errors: runtime (too large for the memory that is free, said before any of it is made).
Result<scenes::Scene> generate_scene(const std::string& name, const GeneratedSceneOptions& options);

}  // namespace vcd::render
