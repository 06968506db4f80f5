// vc-bench: speed against accuracy, measured on this machine.
#include <algorithm>
#include <cstdio>

#include "bake/options.h"
#include "bench/bake_rate.h"
#include "bench/bake_time.h"
#include "bench/demand_run.h"
#include "bench/instances.h"
#include "bench/machine.h"
#include "bench/paper_run.h"
#include "bench/paths.h"
#include "bench/report.h"
#include "bench/segments.h"
#include "bench/stability.h"
#include "common/program.h"
#include "render/instructions.h"

namespace {

using namespace vcd;
using namespace vcd::bench;
using namespace vcd::render;
using namespace vcd::tools;

struct Options {
  CommonOptions common;
  int repetitions = 7;
  std::string instructions;  // empty: all that there are

  std::vector<std::string> scenes;
  bool quick = false;
  std::string folder = "vcd-bench";
  std::vector<std::string> trees;
  std::string size;
  unsigned threads = 0;
  double budget_mb = 0;
  bool horizons = false;

  SegmentsOptions segments;
  InstancesOptions instances;
  PathsOptions paths;
  DemandRunOptions demand;
  MeshToRead mesh;
  library::BakeSettings settings;  // those of reading mesh files
  BakeRateOptions bake_rate;
  BakeTimeOptions bake_time;
  StabilityOptions stability;
};

// What --quick and its absence stand for. Options that are given go before.
struct Profile {
  const char* name;
  std::vector<std::string> scenes;
  std::vector<Configuration> configurations;
  uint32_t width, height;
  uint64_t segments_of_kind;
};

Profile full_profile() {
  Profile profile{"full", {"sierpinski", "hairball", "forest"}, {}, 300, 200, 1 << 17};
  for (uint32_t depth : {5, 6, 7}) {
    for (uint32_t samples : {16, 81, 256}) profile.configurations.push_back({depth, Method::sampled, samples});
    for (Method method : {Method::proven, Method::hybrid}) profile.configurations.push_back({depth, method, 256});
  }
  return profile;
}

Profile quick_profile() {
  return {
      "quick",
      {"sierpinski,level=6", "hairball,strands=1000,segments=10,sides=3", "forest,instances=60,leaves=800,species=2"},
      {{4, Method::sampled, 16},
       {4, Method::sampled, 256},
       {4, Method::proven, 256},
       {4, Method::hybrid, 256},
       {5, Method::sampled, 16}},
      96,
      64,
      1 << 14};
}

// How pictures are measured, with the size that was asked for.
std::optional<Error> set_picture(const Options& options, RenderSettings& render) {
  char trailing = 0;
  if (!options.size.empty() &&
      (std::sscanf(options.size.c_str(), "%ux%u%c", &render.width, &render.height, &trailing) != 2 ||
       render.width < 8 || render.height < 8 || render.width > 16384 || render.height > 16384))
    return Error{ErrorCode::usage, "--size " + options.size + ": not WIDTHxHEIGHT, each 8 to 16384"};
  render.threads = options.threads;
  render.pin = true;
  return std::nullopt;
}

Result<PaperRunOptions> plan(const Options& options, Profile& profile) {
  PaperRunOptions run;
  if (!options.scenes.empty()) profile.scenes = options.scenes;
  if (!options.trees.empty()) profile.configurations.clear();
  for (const std::string& tree : options.trees) {
    const auto c = Configuration::parse(tree);
    if (!c)
      return Error{ErrorCode::usage,
                   "--trees " + tree +
                       ": not DEPTHxKIND with depth 1 to 8 and kind 16, 81, 256 (samples), proven or hybrid; nor "
                       "demandxproven or demandxhybrid"};
    profile.configurations.push_back(*c);
  }
  run.configurations = profile.configurations;
  run.render.width = profile.width, run.render.height = profile.height;
  if (auto fault = set_picture(options, run.render)) return *std::move(fault);
  run.repetitions = options.repetitions;
  run.bakes.budget_mb = options.budget_mb;
  run.bakes.horizons = options.horizons;
  run.paths = std::min(run.paths, size_t{32} * run.render.width * run.render.height);
  run.segments_of_kind = profile.segments_of_kind;
  run.quiet = options.common.quiet;
  for (const std::string& text : profile.scenes) {
    SceneOptions scene;
    scene.files.ingest = options.settings.ingest_options();
    auto request = parse_scene_request(text, scene);
    if (!request) return request.error();
    for (const SceneRequest& other : run.scenes)
      if (other.name == request->name)
        return Error{ErrorCode::usage, text + ": another scene has that name; write NAME=" + text};
    run.scenes.push_back(std::move(*request));
  }
  return run;
}

Json describe(const PaperRunOptions& run, const Profile& profile, const std::string& command) {
  return {{"tool", "vc-bench"},
          {"version", VCD_VERSION},
          {"format", 1},
          {"command", command},
          {"settings",
           {{"profile", profile.name},
            {"width", run.render.width},
            {"height", run.render.height},
            {"pixel_samples", run.render.pixel_samples},
            {"light_samples", run.render.light_samples},
            {"repetitions", run.repetitions},
            {"threads", run.render.threads},
            {"paths", run.paths},
            {"horizons", run.bakes.horizons},
            {"seed", run.render.seed}}},
          {"machine", describe_machine()}};
}

int run_all(const Options& options, const std::string& command) {
  Profile profile = options.quick ? quick_profile() : full_profile();
  const auto run = plan(options, profile);
  if (!run) return print_error(run.error().message), exit_code(run.error().code);
  auto results = Results::open(options.folder, describe(*run, profile, command));
  if (!results) return print_error(results.error().message), exit_code(results.error().code);
  catch_interruptions();
  const int code = batch_exit_code(run_paper(*run, *results));
  if (interrupted()) return exit_code(ErrorCode::runtime);
  const int report = write_report(options.folder);
  if (report == kExitOk && !options.common.quiet) std::printf("%s/report.html\n", options.folder.c_str());
  return code != kExitOk ? code : report;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Measures sidecars against Embree on this machine. Without a subcommand it measures the paper's scenes, and "
      "writes\n"
      "its tables and a report of speed against accuracy. Results are kept: the same command goes on where it "
      "stopped."};
  app.require_subcommand(0, 1);
  app.fallthrough();  // the options of all may come after the subcommand too
  add_common_options(app, options.common);
  app.add_option("--instructions", options.instructions,
                 "Hold Embree and the runtime to these and older ones, avx2 or sse4 (default: what the processor has)")
      ->check(CLI::IsMember(older_instructions()));
  app.add_option("--repetitions", options.repetitions, "How often each variant runs (default: 7)")
      ->check(CLI::Range(1, 1000));
  app.add_flag("--quick", options.quick, "Small scenes, pictures and trees: some minutes instead of a night");
  app.add_option(
         "--scene", options.scenes,
         "[NAME=]SCENE|MESH[,KEY=VALUE]..., again for each: sierpinski, hairball, forest or a mesh file, with keys "
         "up,\n"
         "turn, level, strands, segments, sides, instances, species, leaves, seed (default: the three generated ones)")
      ->type_name("sierpinski|hairball|forest|MESH")
      ->allow_extra_args(false);
  app.add_option("-o,--output", options.folder, "Folder of results, sidecars, pictures and report (default: vcd-bench)")
      ->type_name("DIR");
  app.add_option("--trees", options.trees,
                 "Trees to bake of each scene, DEPTHxKIND with commas; kind: 16, 81, 256 (samples), proven, "
                 "hybrid; demandxproven and\ndemandxhybrid: for the picture's rays, recorded with another seed\n"
                 "(default: 5x16,5x81,5x256,5xproven,5xhybrid,6x16 ... 7xhybrid)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("TREES");
  app.add_option("--budget-mb", options.budget_mb,
                 "MiB of an object that is baked for a demand (default: what vc-bake takes)")
      ->check(CLI::Range(0.02, 1e6));
  app.add_flag("--horizons", options.horizons,
               "Bake horizons into proven and hybrid trees, and measure what begins on an object with them too");
  app.add_option("--size", options.size, "Of the pictures (default: 300x200; demand: 120x80)")->type_name("WxH");
  app.add_option("-j,--threads", options.threads, "Threads of bakes and pictures; 0: all (default); bake-time has one")
      ->check(CLI::Range(0, 1024));

  add_reading_settings(app, options.settings);

  CLI::App* report = app.add_subcommand("report", "Write the report of a folder of results again");
  report->add_option("folder", options.folder, "What -o named")->required()->type_name("DIR");

  CLI::App* segments =
      app.add_subcommand("segments", "One sidecar: answers, shares and times of segments with and without it");
  segments->add_option("sidecar", options.segments.sidecar, "The sidecar to ask")->required()->type_name("SIDECAR");
  segments->add_option("mesh", options.segments.mesh.path, "The mesh file that it was baked from")
      ->required()
      ->type_name("MESH");
  segments->add_option("--object", options.segments.object, "Index of the object in the sidecar (default: 0)");
  segments->add_option("--points", options.segments.points, "Ground points, 128 shadow rays each (default: 4000)")
      ->check(CLI::Range(1, 1000000));

  CLI::App* instances =
      app.add_subcommand("instances", "A scene of instances: times of shadow rays with sidecars and without");
  instances->add_option("scene", options.instances.scene, "SCENE|MESH[,KEY=VALUE]..., as --scene")
      ->required()
      ->type_name("sierpinski|hairball|forest|MESH");
  instances->add_option("sidecars", options.instances.sidecars, "Of its meshes")->required()->type_name("SIDECAR");
  instances->add_option("--points", options.instances.points, "Points, 128 shadow rays each (default: 3000)")
      ->check(CLI::Range(1, 1000000));

  CLI::App* paths = app.add_subcommand("paths", "The shadow rays of a path tracer: times with sidecars and without");
  paths->add_option("scene", options.paths.scene, "SCENE|MESH[,KEY=VALUE]..., as --scene")
      ->required()
      ->type_name("sierpinski|hairball|forest|MESH");
  paths->add_option("sidecars", options.paths.sidecars, "Of its meshes, with hierarchies")
      ->required()
      ->type_name("SIDECAR");
  paths->add_option("--points", options.paths.points, "Points that the camera sees, a path each (default: 100000)")
      ->check(CLI::Range(1, 100000000));
  paths->add_option("--bounces", options.paths.bounces, "Surface points of a path, a shadow ray each (default: 4)")
      ->check(CLI::Range(1, 4));

  CLI::App* demand = app.add_subcommand(
      "demand", "Sidecars baked for what a scene asks: asked by the same camera, by others, and under other lights");
  demand->add_option("scene", options.demand.scene, "SCENE|MESH[,KEY=VALUE]..., as --scene")
      ->required()
      ->type_name("sierpinski|hairball|forest|MESH");
  demand->add_option("-d,--depth", options.demand.depth, "Of the sidecars for any scene (default: 5)")
      ->check(CLI::Range(1, 8));
  demand->add_option("--most-recorded", options.demand.most_recorded, "Shadow rays of a demand (default: 2097152)")
      ->check(CLI::Range(size_t{1024}, kMostAskedSegments));
  demand->add_option("--judged", options.demand.judged,
                     "Judge so many segments of further pictures exactly, with each sidecar (default: 0)");
  demand->add_flag("--proven-only", options.demand.proven_only, "No hybrid sidecars");

  CLI::App* bake = app.add_subcommand("bake-rate", "How fast a bake traces, against bare rtcOccluded16 on its rays");
  bake->add_option("mesh", options.mesh.path, "Mesh file; its first mesh is baked")->required()->type_name("MESH");
  bake->add_option("-d,--depth", options.bake_rate.depth, "Depth of the bake (default: 5)")->check(CLI::Range(1, 8));
  bake->add_option("-s,--samples", options.bake_rate.samples, "Rays a cell (default: 256)")
      ->check(CLI::IsMember({16, 81, 256}).description(""))
      ->type_name("16|81|256");
  bake->add_option("--cells", options.bake_rate.top_cells, "Random cells of level 3 to bake (default: 200)");

  CLI::App* time = app.add_subcommand("bake-time", "What a bake costs by proof, hybrid and by 256 samples");
  time->add_option("mesh", options.mesh.path, "Mesh file; its first mesh is baked")->required()->type_name("MESH");
  time->add_option("-d,--depth", options.bake_time.depths, "Depths, with commas (default: 5,6,7)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::Range(1, 8))
      ->type_name("DEPTHS");
  time->add_option("--one-in", options.bake_time.one_in,
                   "Classify one in so many of the 61,440 cells of the top table (default: 40)")
      ->check(CLI::Range(1, 60000));

  CLI::App* stability = app.add_subcommand(
      "stability", "Where methods fail: parameters driven to their extremes, every answer judged exactly");
  stability->add_option("-d,--depth", options.stability.bakes.depth, "Depth of the sidecars (default: 4)")
      ->check(CLI::Range(1, 8));
  stability->add_flag("--for-segments", options.stability.bakes.for_segments,
                      "Bake deep only where a sample of each point's segments goes, drawn with another seed; needed "
                      "for depths 7 and 8");

  std::string command = "vc-bench";
  for (int i = 1; i < argc; ++i) command += std::string(" ") + argv[i];
  return run_program(app, argc, argv, [&] {
    limit_instructions(options.instructions);
    options.segments.repetitions = options.repetitions, options.segments.format = options.common.format;
    options.instances.repetitions = options.repetitions, options.instances.format = options.common.format;
    options.paths.repetitions = options.repetitions, options.paths.format = options.common.format;
    options.mesh.ingest = options.segments.mesh.ingest = options.instances.ingest = options.paths.ingest =
        options.settings.ingest_options();
    options.mesh.quiet = options.segments.mesh.quiet = options.instances.quiet = options.paths.quiet =
        options.common.quiet;
    if (demand->parsed()) {
      options.demand.ingest = options.settings.ingest_options(), options.demand.quiet = options.common.quiet;
      options.demand.budget_mb = options.budget_mb;
      options.demand.format = options.common.format, options.demand.repetitions = options.repetitions;
      options.demand.folder = options.folder, options.demand.render.width = 120, options.demand.render.height = 80;
      if (const auto fault = set_picture(options, options.demand.render))
        return print_error(fault->message), exit_code(fault->code);
      return run_demand(options.demand);
    }
    if (instances->parsed()) return run_instances(options.instances);
    if (paths->parsed()) return run_paths(options.paths);
    if (segments->parsed()) return run_segments(options.segments);
    if (bake->parsed())
      return run_bake_rate(options.mesh, options.bake_rate, options.repetitions, options.common.format);
    if (stability->parsed()) {
      if (options.stability.bakes.depth > 6 && !options.stability.bakes.for_segments)
        return print_error("stability --depth 7 and 8 need --for-segments"), exit_code(ErrorCode::usage);
      options.stability.folder = options.folder, options.stability.quick = options.quick;
      const int code = run_stability(options.stability, command, options.common.format);
      if (!std::filesystem::exists(std::filesystem::path(options.folder) / "results.json")) return code;
      const int page = write_report(options.folder);  // the sweeps are a section of the pictures' report
      return code != kExitOk ? code : page;
    }
    if (time->parsed())
      return run_bake_time(options.mesh, options.bake_time, options.repetitions, options.common.format);
    if (report->parsed()) return write_report(options.folder);
    return run_all(options, command);
  });
}
