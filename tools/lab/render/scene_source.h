// The scene that a program is asked for: a generated one by its name, or mesh files.
#pragma once

#include <string>
#include <vector>

#include "generated_scene.h"
#include "mesh_parts.h"
#include "world.h"

namespace vcd::render {

struct SceneOptions {
  GeneratedSceneOptions generated;
  char up = 'y';            // of mesh files
  double turn_degrees = 0;  // likewise
  FileOptions files;        // likewise
};

// Those of generated scenes (--scene-seed for the seed), --up and --turn.
void add_scene_options(CLI::App& app, SceneOptions& options);

// What the arguments name: one generated scene; or one mesh file, its meshes where its nodes place them; or several
// files, whose meshes stand together in the frame that they share. Errors: usage; those of read_parts() and
// build_world(). Notes are printed unless quiet.
Result<World> load_world(const std::vector<std::string>& names, const SceneOptions& options, bool quiet);

}  // namespace vcd::render
