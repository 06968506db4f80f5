// vc-render: pictures with soft shadows, by Embree alone or with sidecars, and what the sidecars saved.
#include <cstdio>
#include <filesystem>
#include <map>
#include <random>
#include <set>

#include <vcd/writer/demand.h>

#include "bake/options.h"
#include "common/describe.h"
#include "common/program.h"
#include "common/progress.h"
#include "render/census.h"
#include "render/false_colour.h"
#include "render/faults.h"
#include "render/recorded.h"
#include "render/recording.h"
#include "render/renderer.h"
#include "render/scene_source.h"
#include "render/sidecars.h"

namespace {

namespace fs = std::filesystem;
using namespace vcd;
using namespace vcd::baker;
using namespace vcd::render;
using namespace vcd::tools;

enum class Shadows { bvh, vcd, both };

struct Options {
  CommonOptions common;
  std::vector<std::string> names;
  SceneOptions scene;
  RenderSettings render;
  std::string size = "480x320";
  Shadows shadows = Shadows::vcd;
  std::vector<std::string> views = {"shaded"};
  std::vector<std::string> sidecars;
  library::BakeSettings settings{.depth = 5};
  std::string output, record;
  size_t most_recorded = Recorder::kDefaultMost;
  bool exr = false;
  double exposure = 1, amplify = 20;

  bool wants(const char* view) const { return std::find(views.begin(), views.end(), view) != views.end(); }
};

// A sidecar that is baked for this picture only.
class TemporaryFile {
 public:
  TemporaryFile()
      : path_(fs::temp_directory_path() / ("vc-render-" + std::to_string(std::random_device{}()) + ".vcd")) {}
  ~TemporaryFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// One way of casting shadows: its picture, and its counts where a view needs them.
struct Variant {
  std::string name;  // "bvh" or "vcd"
  ShadowWays ways;
  Rendered rendered;
  std::optional<CensusPass> census;
};

class Program {
 public:
  explicit Program(const Options& options) : options_(options) {}

  int run() {
    SceneOptions scene = options_.scene;
    scene.files = files();
    auto world = load_world(options_.names, scene, options_.common.quiet);
    if (!world) return fail(world.error());
    world_.emplace(std::move(*world));
    if (options_.shadows != Shadows::bvh)
      if (auto error = find_sidecars()) return fail(*error);
    if (options_.wants("tests") || options_.wants("fallback")) {
      auto counter = TestCounter::build(*world_);
      if (!counter) return fail(counter.error());
      counter_.emplace(std::move(*counter));
    }
    for (const char* name : {"bvh", "vcd"}) {
      if (options_.shadows != Shadows::both && (options_.shadows == Shadows::bvh) != (std::string(name) == "bvh"))
        continue;
      if (auto error = render_variant(name)) return fail(*error);
    }
    if (auto error = write_views()) return fail(*error);
    if (!options_.common.quiet)
      for (const std::string& note : faults_of(*world_, options_.render, variants_[0].rendered)) print_note(note);
    report();
    return kExitOk;
  }

 private:
  static int fail(const Error& error) {
    print_error(error.message);
    return exit_code(error.code);
  }

  // Those that are named; else those beside the meshes.
  std::vector<std::string> sidecar_paths() const {
    std::vector<std::string> paths = options_.sidecars;
    if (paths.empty() && !is_generated_scene(options_.names[0]))
      for (const std::string& mesh : options_.names)
        if (fs::exists(mesh + ".vcd")) paths.push_back(mesh + ".vcd");
    return paths;
  }

  // Without shadows of a sidecar, what the user says of reading goes before what a sidecar says that lies there.
  FileOptions files() const {
    const IngestOptions ingest = options_.settings.ingest_options();
    const bool says_how = ingest.treat_all_as_opaque || ingest.shift != IngestOptions{}.shift || ingest.subdivide > 0;
    if (options_.shadows == Shadows::bvh && says_how) return {ingest, {}};
    return {ingest, sidecar_paths()};
  }

  // sidecar_paths(), else one that is baked on the spot.
  std::optional<Error> find_sidecars() {
    std::vector<std::string> paths = sidecar_paths();
    if (paths.empty()) {
      if (!options_.common.quiet)
        print_note("no sidecar given or found: baking one for this picture, depth " +
                   std::to_string(options_.settings.depth) + ", " + method_name(options_.settings.method) +
                   " (vc-bake keeps it)");
      BakeOptions bake = options_.settings.bake_options();
      bake.stop = interrupted;
      bake.threads = options_.render.threads;
      std::optional<ProgressLine> line;
      const WorldObject* current = nullptr;
      const auto baked =
          bake_world(*world_, bake, temporary_.path(), [&](const WorldObject& object, const BakeProgress& p) {
            if (current != &object) line.emplace("baking " + printable(object.mesh.name), options_.common.quiet);
            current = &object;
            line->update(p);
          });
      if (!baked) return baked.error();
      paths.push_back(temporary_.path().string());
    }
    auto opened = open_sidecars(*world_, paths);
    if (!opened) return opened.error();
    sidecars_.emplace(std::move(*opened));
    return std::nullopt;
  }

  std::unique_ptr<ShadowCaster> caster(const std::string& name, const ShadowWays& ways) const {
    if (name == "bvh") return std::make_unique<BvhShadows>(*world_, ways);
    return std::make_unique<SidecarShadows>(*world_, sidecars_->objects, ways);
  }

  Result<Rendered> render_with(const std::string& label, const MakeCaster& make_caster) const {
    ProgressLine line(world_->name + " " + label, options_.common.quiet);
    RenderHooks hooks;
    hooks.stop = interrupted;
    hooks.progress = [&](const RenderProgress& p) { line.update({p.fraction, p.shadow_segments, p.seconds}); };
    return render::render(*world_, options_.render, make_caster, hooks);
  }

  // Of the first variant: the others ask the same.
  Result<std::optional<Recorder>> recorder_if_asked() const {
    if (options_.record.empty() || !variants_.empty()) return std::optional<Recorder>();
    auto recorder = recorder_of(*world_, options_.most_recorded);
    if (!recorder) return recorder.error();
    return std::optional<Recorder>(std::move(*recorder));
  }
  std::optional<Error> write_recorded(const Recorder& recorder) {
    const auto written = write_demand(options_.record, recorder.demand());
    if (!written) return written.error();
    files_.push_back(options_.record);
    return std::nullopt;
  }

  std::optional<Error> render_variant(const std::string& name) {
    Variant variant{name, {}, {}, {}};
    variant.ways =
        fastest_ways(*world_, options_.render, name == "vcd", [&](const ShadowWays& w) { return caster(name, w); });
    auto recorder = recorder_if_asked();
    if (!recorder) return recorder.error();
    auto rendered = render_with(name, [&]() -> std::unique_ptr<ShadowCaster> {
      if (!*recorder) return caster(name, variant.ways);
      return std::make_unique<RecordedShadows>(caster(name, variant.ways), (*recorder)->thread());
    });
    if (!rendered) return rendered.error();
    if (*recorder)
      if (auto error = write_recorded(**recorder)) return error;
    variant.rendered = std::move(*rendered);
    if (counter_) {
      Census census(*world_, name == "bvh" ? std::vector<Object>{} : sidecars_->objects, *counter_, EmbreeQuery{1},
                    variant.rendered.image.pixels.size());
      const auto counted = render_with(name + ", counting", [&] { return census.caster(); });
      if (!counted) return counted.error();
      variant.census = census.take();
    }
    variants_.push_back(std::move(variant));
    return std::nullopt;
  }

  std::optional<Error> write(const std::string& suffix, const Image& image) {
    const std::string path = prefix() + suffix + ".png";
    files_.push_back(path);
    return write_png(path, image);
  }

  std::string prefix() const { return options_.output.empty() ? world_->name : options_.output; }

  std::optional<Error> write_counts(const std::string& suffix, const std::vector<double> CensusPass::*counts,
                                    bool of_bvh, const std::string& caption) {
    double scale = 0;  // one for all, so that pictures can be compared
    for (const Variant& v : variants_) scale = std::max(scale, scale_for((*v.census).*counts));
    for (const Variant& v : variants_) {
      if (v.name == "bvh" && !of_bvh) continue;
      if (auto error = write("-" + v.name + suffix, false_colour((*v.census).*counts, options_.render.width,
                                                                 options_.render.height, scale, caption)))
        return error;
    }
    return std::nullopt;
  }

  std::optional<Error> write_views() {
    for (const Variant& v : variants_) {
      if (!options_.wants("shaded")) break;
      if (auto error = write("-" + v.name, tone_mapped(v.rendered.image, static_cast<float>(options_.exposure))))
        return error;
      if (!options_.exr) continue;
      files_.push_back(prefix() + "-" + v.name + ".exr");
      if (auto error = write_exr(files_.back(), v.rendered.image)) return error;
    }
    if (options_.wants("tests"))
      if (auto error =
              write_counts("-tests", &CensusPass::pixel_tests, true, "ray-triangle tests of a pixel's shadow rays"))
        return error;
    if (options_.wants("fallback"))
      if (auto error =
              write_counts("-fallback", &CensusPass::pixel_open, false, "shadow rays of a pixel that needed the BVH"))
        return error;
    if (options_.wants("difference"))
      if (auto error =
              write("-difference", amplified_difference(variants_[0].rendered.image, variants_[1].rendered.image,
                                                        static_cast<float>(options_.amplify))))
        return error;
    return std::nullopt;
  }

  Json describe(const Variant& v) const {
    Json json{{"shadows", v.name},
              {"packets", text_of(v.ways)},
              {"seconds", v.rendered.seconds},
              {"shadow_thread_seconds", v.rendered.shadow_seconds},
              {"shadow_segments", v.rendered.shadow_segments}};
    if (!v.census) return json;
    json["tests"] = v.census->tests;
    if (v.name == "bvh") return json;
    const KindCounts all = v.census->total();
    json["resolved"] = all.resolved();
    json["wrong"] = all.wrong;
    return json;
  }

  void report() const {
    std::optional<Difference> difference;
    if (variants_.size() == 2) difference = compare(variants_[0].rendered.image, variants_[1].rendered.image);
    if (options_.common.format == OutputFormat::json) {
      Json json{{"tool", "vc-render"},
                {"version", VCD_VERSION},
                {"scene", world_->name},
                {"triangles", world_->triangles()},
                {"instances", world_->instances.size()},
                {"files", files_}};
      for (const Variant& v : variants_) json["variants"].push_back(describe(v));
      if (difference)
        json["difference"] = {
            {"rmse", difference->rmse}, {"maximum", difference->maximum}, {"pixels", difference->pixels}};
      return print_json(json);
    }
    if (options_.common.quiet) return;
    std::printf("%s: %s triangles, %zu instance%s; %s shadow rays\n", world_->name.c_str(),
                readable_count(static_cast<double>(world_->triangles())).c_str(), world_->instances.size(),
                world_->instances.size() == 1 ? "" : "s",
                readable_count(static_cast<double>(variants_[0].rendered.shadow_segments)).c_str());
    for (const Variant& v : variants_) {
      std::printf(
          "  %s  %s, %.1f ns a shadow ray (%s)\n", v.name.c_str(), readable_seconds(v.rendered.seconds).c_str(),
          1e9 * v.rendered.shadow_seconds / static_cast<double>(std::max<uint64_t>(v.rendered.shadow_segments, 1)),
          text_of(v.ways).c_str());
      if (!v.census) continue;
      std::printf("       %s ray-triangle tests of shadow rays",
                  readable_count(static_cast<double>(v.census->tests)).c_str());
      const KindCounts all = v.census->total();
      if (v.name == "vcd")
        std::printf(
            "; %.1f %% of them needed no BVH, %.4f %% got a wrong answer",
            100.0 * static_cast<double>(all.resolved()) / static_cast<double>(std::max<uint64_t>(all.segments, 1)),
            100.0 * static_cast<double>(all.wrong) / static_cast<double>(std::max<uint64_t>(all.segments, 1)));
      std::printf("\n");
    }
    if (difference)
      std::printf("  the pictures differ in %llu of %zu pixels: RMSE %.3g, at most %.3g\n",
                  static_cast<unsigned long long>(difference->pixels), variants_[0].rendered.image.pixels.size(),
                  difference->rmse, difference->maximum);
    for (const std::string& file : files_) std::printf("  %s\n", file.c_str());
  }

  const Options& options_;
  std::optional<World> world_;
  TemporaryFile temporary_;
  std::optional<WorldSidecars> sidecars_;
  std::optional<TestCounter> counter_;
  std::vector<Variant> variants_;
  std::vector<std::string> files_;
};

// Empty, or what is wrong with the options.
std::string check(Options& options) {
  char trailing = 0;
  if (std::sscanf(options.size.c_str(), "%ux%u%c", &options.render.width, &options.render.height, &trailing) != 2 ||
      options.render.width < 1 || options.render.height < 1 || options.render.width > 16384 ||
      options.render.height > 16384)
    return "--size " + options.size + ": not WIDTHxHEIGHT, each 1 to 16384";
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

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Renders a generated scene (sierpinski, hairball, forest) or mesh files, on the ground under area lights. Shadow "
      "rays\n"
      "are answered by Embree (bvh), by sidecars and Embree for rays that stay unclassified (vcd), or by each (both)."};
  app.add_option("scene", options.names, "A generated scene, or mesh files")
      ->required()
      ->type_name("sierpinski|hairball|forest|MESH...");
  const std::map<std::string, Shadows> kShadows = {
      {"bvh", Shadows::bvh}, {"vcd", Shadows::vcd}, {"both", Shadows::both}};
  app.add_option("--shadows", options.shadows, "What answers shadow rays (default: vcd)")
      ->transform(CLI::CheckedTransformer(kShadows, CLI::ignore_case).description(""))
      ->type_name("bvh|vcd|both");
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
      ->check(CLI::Range(size_t{1}, kMaxBundle));
  app.add_option("--seed", options.render.seed, "Of the samples (default: 1)");
  app.add_option("-j,--threads", options.render.threads, "Threads; 0: all (default)")->check(CLI::Range(0, 1024));
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
  return run_program(app, argc, argv, [&] {
    if (const std::string fault = check(options); !fault.empty()) {
      print_error(fault);
      return exit_code(ErrorCode::usage);
    }
    catch_interruptions();
    return Program(options).run();
  });
}
