// vc-render: pictures with soft shadows, by Embree alone or with sidecars, and what the sidecars saved.
#include <cstdio>
#include <filesystem>
#include <random>

#include <vcd/writer/demand.h>

#include "common/describe.h"
#include "common/progress.h"
#include "render/census.h"
#include "render/false_colour.h"
#include "render/faults.h"
#include "render/instructions.h"
#include "render/recorded.h"
#include "render/recording.h"
#include "render/sidecars.h"
#include "vc_render_options.h"

namespace {

namespace fs = std::filesystem;
using namespace vcd;
using namespace vcd::baker;
using namespace vcd::render;
using namespace vcd::tools;

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
  std::string way;   // what answered
  Rendered rendered;
  std::optional<CensusPass> census;
};

class Program {
 public:
  explicit Program(const PictureOptions& options) : options_(options) {}

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
    if ((options_.behind == Behind::hierarchy || options_.paths != Paths::none) &&
        !have_hierarchies(sidecars_->objects))
      return Error{ErrorCode::usage, paths[0] + ": without a hierarchy of triangles, which " +
                                         (options_.paths == Paths::none ? "--behind hierarchy" : "--paths") +
                                         " needs; bake it again without --no-hierarchy"};
    if (options_.paths != Paths::none) answers_.emplace(*world_, sidecars_->objects, true);
    return std::nullopt;
  }

  // Where no BVH is behind them.
  std::string answered_by() const {
    return some_has_horizons(sidecars_->objects) ? "look-ups, horizons, hierarchy" : "look-ups, hierarchy";
  }
  bool by_hierarchy(const std::string& name) const {
    return name == "vcd" && options_.behind != Behind::bvh && have_hierarchies(sidecars_->objects);
  }

  std::unique_ptr<ShadowCaster> caster(const std::string& name, const ShadowWays& ways) const {
    if (name == "bvh") return std::make_unique<BvhShadows>(*world_, ways);
    if (by_hierarchy(name)) return std::make_unique<HierarchyShadows>(*world_, sidecars_->objects, true);
    return std::make_unique<SidecarShadows>(*world_, sidecars_->objects, ways);
  }

  std::unique_ptr<PathCaster> path_caster(const std::string& name, EmbreeQuery way) const {
    if (name == "bvh") return std::make_unique<BvhPaths>(*world_, way);
    return std::make_unique<HierarchyPaths>(*answers_, options_.path_picture.wavefronts);
  }

  // draw(hooks) -> Result<Rendered>.
  template <class Draw>
  Result<Rendered> drawn(const std::string& label, const Draw& draw) const {
    ProgressLine line(world_->name + " " + label, options_.common.quiet);
    RenderHooks hooks;
    hooks.stop = interrupted;
    hooks.progress = [&](const RenderProgress& p) { line.update({p.fraction, p.shadow_segments, p.seconds}); };
    return draw(hooks);
  }
  Result<Rendered> render_with(const std::string& label, const MakeCaster& make_caster) const {
    return drawn(
        label, [&](const RenderHooks& hooks) { return render::render(*world_, options_.render, make_caster, hooks); });
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

  Result<Rendered> render_bundles(Variant& variant, std::optional<Recorder>& recorder) const {
    ShadowWays ways;
    if (by_hierarchy(variant.name)) {
      variant.way = answered_by();
    } else {
      ways = fastest_ways(*world_, options_.render, variant.name == "vcd",
                          [&](const ShadowWays& w) { return caster(variant.name, w); });
      variant.way = text_of(ways);
    }
    return render_with(variant.name, [&]() -> std::unique_ptr<ShadowCaster> {
      if (!recorder) return caster(variant.name, ways);
      return std::make_unique<RecordedShadows>(caster(variant.name, ways), recorder->thread());
    });
  }

  Result<Rendered> render_paths(Variant& variant, std::optional<Recorder>& recorder) const {
    EmbreeQuery way;
    if (variant.name == "bvh") way = fastest_way(*world_, options_.render, options_.path_picture);
    variant.way = variant.name == "bvh" ? name_of(way) : answered_by();
    return drawn(variant.name, [&](const RenderHooks& hooks) {
      return render::render_paths(
          *world_, options_.render, options_.path_picture,
          [&]() -> std::unique_ptr<PathCaster> {
            if (!recorder) return path_caster(variant.name, way);
            return std::make_unique<RecordedPaths>(path_caster(variant.name, way), recorder->thread());
          },
          hooks);
    });
  }

  std::optional<Error> render_variant(const std::string& name) {
    Variant variant{name, {}, {}, {}};
    auto recorder = recorder_if_asked();
    if (!recorder) return recorder.error();
    auto rendered =
        options_.paths == Paths::none ? render_bundles(variant, *recorder) : render_paths(variant, *recorder);
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
              {"answered_by", v.way},
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
          v.way.c_str());
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

  const PictureOptions& options_;
  std::optional<World> world_;
  TemporaryFile temporary_;
  std::optional<WorldSidecars> sidecars_;
  std::optional<SidecarPaths> answers_;  // to shadow rays of paths
  std::optional<TestCounter> counter_;
  std::vector<Variant> variants_;
  std::vector<std::string> files_;
};

}  // namespace

int main(int argc, char** argv) {
  PictureOptions options;
  CLI::App app{
      "Renders a generated scene (sierpinski, hairball, forest) or mesh files, on the ground under area lights. Shadow "
      "rays\n"
      "are answered by Embree (bvh), by sidecars (vcd), or by each (both)."};
  add_options(app, options);
  return run_program(app, argc, argv, [&] {
    if (const std::string fault = check(options); !fault.empty()) {
      print_error(fault);
      return exit_code(ErrorCode::usage);
    }
    limit_instructions(options.instructions);
    catch_interruptions();
    return Program(options).run();
  });
}
