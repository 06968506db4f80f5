// What vc-render is told.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <vcd/recorder/recorder.h>

#include "bake/options.h"
#include "common/program.h"
#include "render/path_picture.h"
#include "render/scene_source.h"

namespace vcd::render {

enum class Shadows { bvh, vcd, both };
enum class Behind { any, hierarchy, bvh };
enum class Paths { none, single, wavefronts };

struct PictureOptions {
  tools::CommonOptions common;
  std::vector<std::string> names;
  SceneOptions scene;
  RenderSettings render;
  std::string size = "480x320";
  Shadows shadows = Shadows::vcd;
  Behind behind = Behind::any;
  Paths paths = Paths::none;
  PathPicture path_picture;
  std::vector<std::string> views = {"shaded"};
  std::vector<std::string> sidecars;
  library::BakeSettings settings{.depth = 5};
  std::string output, record, instructions;
  size_t most_recorded = Recorder::kDefaultMost;
  bool exr = false;
  double exposure = 1, amplify = 20;

  bool wants(const char* view) const { return std::find(views.begin(), views.end(), view) != views.end(); }
};

// The command line. `options` outlives the app.
void add_options(CLI::App& app, PictureOptions& options);

// Of what was parsed: empty, or what is wrong with it. Sets what follows from several options.
std::string check(PictureOptions& options);

}  // namespace vcd::render
