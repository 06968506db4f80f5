#include "vc_render_options.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>

#include "render/instructions.h"

namespace vcd::render {

using namespace baker;
using namespace tools;
namespace fs = std::filesystem;

std::string check(PictureOptions& options) {
  char trailing = 0;
  if (std::sscanf(options.size.c_str(), "%ux%u%c", &options.render.width, &options.render.height, &trailing) != 2 ||
      options.render.width < 1 || options.render.height < 1 || options.render.width > 16384 ||
      options.render.height > 16384)
    return "--size " + options.size + ": not WIDTHxHEIGHT, each 1 to 16384";
  if (options.paths != Paths::none) {
    if (options.wants("tests") || options.wants("fallback")) return "--paths has no views tests and fallback";
    if (options.behind == Behind::bvh) return "--paths asks sidecars without a BVH behind them: not with --behind bvh";
    options.path_picture.wavefronts = options.paths == Paths::wavefronts;
  }
  if (options.wants("difference") && options.shadows != Shadows::both)
    return "the view difference needs --shadows both";
  if (options.wants("fallback") && options.shadows == Shadows::bvh)
    return "the view fallback needs --shadows vcd or both";
  if (!options.record.empty() && !library::may_be_written(options.record))
    return "--record " + options.record + ": is named like a mesh or a sidecar";
  const fs::path folder = fs::path(options.output).parent_path();
  if (!folder.empty() && !fs::is_directory(folder)) return options.output + ": its folder does not exist";
  return {};
}

void add_options(CLI::App& app, PictureOptions& options) {
  app.add_option("scene", options.names, "A generated scene, or mesh files")
      ->required()
      ->type_name("sierpinski|hairball|forest|MESH...");
  const std::map<std::string, Shadows> kShadows = {
      {"bvh", Shadows::bvh}, {"vcd", Shadows::vcd}, {"both", Shadows::both}};
  app.add_option("--shadows", options.shadows, "What answers shadow rays (default: vcd)")
      ->transform(CLI::CheckedTransformer(kShadows, CLI::ignore_case).description(""))
      ->type_name("bvh|vcd|both");
  const std::map<std::string, Behind> kBehind = {{"hierarchy", Behind::hierarchy}, {"bvh", Behind::bvh}};
  app.add_option("--behind", options.behind,
                 "What answers shadow rays that look-ups leave unclassified: the sidecars' hierarchies, or Embree\n"
                 "(default: hierarchy, where all sidecars have one)")
      ->transform(CLI::CheckedTransformer(kBehind, CLI::ignore_case).description(""))
      ->type_name("hierarchy|bvh");
  const std::map<std::string, Paths> kPaths = {{"single", Paths::single}, {"wavefronts", Paths::wavefronts}};
  CLI::Option* paths = app.add_option("--paths", options.paths,
                                      "Trace paths instead, a shadow ray at each of their points, to a light or to the "
                                      "sky:\nray by ray, or those of 4,096 paths at once. --pixel-samples counts paths")
                           ->transform(CLI::CheckedTransformer(kPaths, CLI::ignore_case).description(""))
                           ->type_name("single|wavefronts");
  app.add_option("--bounces", options.path_picture.bounces, "Points of a path (default: 4)")
      ->check(CLI::Range(1u, kMostBounces))
      ->needs(paths);
  app.add_option("--views", options.views,
                 "Pictures to write, with commas: shaded, tests (ray-triangle tests a pixel), fallback\n"
                 "(shadow rays a pixel that needed the BVH), difference (of both, amplified) (default: shaded)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"shaded", "tests", "fallback", "difference"}).description(""))
      ->type_name("shaded|tests|fallback|difference");
  app.add_option("-o,--output", options.output, "What the pictures' names begin with (default: the scene's name)")
      ->type_name("PATH");
  app.add_flag("--exr", options.exr, "Write the shaded pictures as linear OpenEXR too");
  app.add_option("--size", options.size, "Of the picture (default: 480x320)")->type_name("WxH");
  app.add_option("--pixel-samples", options.render.pixel_samples, "Camera rays a pixel (default: 16)")
      ->check(CLI::Range(1, 4096));
  app.add_option("--light-samples", options.render.light_samples,
                 "Shadow rays from each point to each light (default: 128)")
      ->check(CLI::Range(size_t{1}, kMaxBundle))
      ->excludes(paths);
  app.add_option("--seed", options.render.seed, "Of the samples (default: 1)");
  app.add_option("-j,--threads", options.render.threads, "Threads; 0: all (default)")->check(CLI::Range(0, 1024));
  app.add_option("--instructions", options.instructions,
                 "Hold Embree and the runtime to these and older ones, avx2 or sse4 (default: what the processor has)")
      ->check(CLI::IsMember(older_instructions()));
  app.add_option("--exposure", options.exposure, "Factor before tone mapping (default: 1)")->check(CLI::PositiveNumber);
  app.add_option("--amplify", options.amplify, "Factor of the view difference (default: 20)")
      ->check(CLI::PositiveNumber);
  app.add_option("--sidecar", options.sidecars,
                 "A sidecar to use, again for each (default: MESH.vcd beside each mesh, else one is baked on the spot)")
      ->allow_extra_args(false)
      ->type_name("SIDECAR");
  app.add_option("--record", options.record,
                 "Write the shadow rays, or an even sample of them, as a demand: for vc-bake --for")
      ->type_name("FILE");
  app.add_option("--most-recorded", options.most_recorded, "Shadow rays that each thread records (default: 262144)")
      ->check(CLI::Range(size_t{1}, size_t{1} << 24));
  app.add_option("-d,--depth", options.settings.depth, "Depth of a sidecar that is baked on the spot (default: 5)")
      ->check(CLI::Range(1, 8));
  for (const library::Setting& setting : library::settings_table())
    if (setting.name == "method" || setting.name == "samples") add_setting(app, options.settings, setting);
  add_reading_settings(app, options.settings);
  add_scene_options(app, options.scene);
  add_common_options(app, options.common);
}

}  // namespace vcd::render
