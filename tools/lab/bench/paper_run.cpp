#include "paper_run.h"

#include <algorithm>
#include <memory>
#include <numeric>

#include <vcd/baker/audit.h>

#include "common/describe.h"
#include "common/program.h"
#include "common/progress.h"
#include "kinds.h"
#include "path_bench.h"
#include "render/census.h"
#include "render/false_colour.h"
#include "render/sidecars.h"
#include "scene_bakes.h"
#include "variant_json.h"

namespace vcd::bench {

using namespace baker;
using namespace tools;
using namespace render;
namespace {

namespace fs = std::filesystem;
constexpr const char* kSingle = "bvh-single";  // ray by ray, as the paper's renderer traced

struct OpenVariant {
  std::string id;
  WorldSidecars sidecars;
  ShadowWays ways = {};
};

// What pictures are timed and counted with: Embree, sidecars with Embree behind them, and sidecars with their
// hierarchies.
struct Caster {
  std::string id, label;  // no label: it has one already, or its id says it
  std::string tree;       // the variant that is looked up before the hierarchy; else empty
  bool by_horizons;
  const std::vector<Object>* objects;  // of casters without Embree
  MakeCaster make;
};

// The steps of one scene. Each asks its entry in the results what is there already.
class SceneRun : SceneEntry {
 public:
  SceneRun(const PaperRunOptions& options, const SceneRequest& request, Results& results)
      : SceneEntry(request.name, results), options_(options), request_(request) {}

  std::optional<Error> run() {
    if (scene().contains("request") && scene()["request"] != describe_request())
      return Error{ErrorCode::difference,
                   request_.name + ": measured with other options: " + scene()["request"].dump() + " there, " +
                       describe_request().dump() + " now; give it another name, or another folder with -o"};
    scene()["request"] = describe_request();
    scene()["status"] = "partial";
    scene().erase("error");
    configurations_ = with_measured(options_.configurations, scene());
    auto world = load_world(request_.source, request_.options, options_.quiet);
    if (!world) return world.error();
    world_.emplace(std::move(*world));
    describe_world();
    for (const auto step : {&SceneRun::bake_all, &SceneRun::open_all, &SceneRun::count_all, &SceneRun::time_pictures,
                            &SceneRun::time_kinds, &SceneRun::time_paths}) {
      if (auto error = (this->*step)()) return error;
      if (auto error = results_.save()) return error;
    }
    scene()["status"] = "complete";
    return results_.save();
  }

 private:
  Json describe_request() const {
    const SceneOptions& o = request_.options;
    const std::string& source = request_.source[0];
    Json json{{"source", is_generated_scene(source) ? source : fs::path(source).filename().string()}};
    if (source == "sierpinski") json["level"] = o.generated.level;
    if (source == "hairball")
      json.update({{"strands", o.generated.hairball.strands},
                   {"segments", o.generated.hairball.segments},
                   {"sides", o.generated.hairball.sides},
                   {"seed", o.generated.hairball.seed}});
    if (source == "forest")
      json.update({{"instances", o.generated.forest.instances},
                   {"species", o.generated.forest.species},
                   {"leaves", o.generated.forest.leaves},
                   {"seed", o.generated.forest.seed}});
    if (is_generated_scene(source)) return json;
    json.update({{"up", std::string(1, o.up)}, {"turn", o.turn_degrees}});
    const IngestOptions &ingest = o.files.ingest, usual;
    if (ingest.treat_all_as_opaque) json["parts"] = "all, as opaque";
    if (ingest.shift != usual.shift) json["shift"] = ingest.shift;
    if (ingest.subdivide > 0) json["subdivide"] = ingest.subdivide;
    return json;
  }

  void describe_world() {
    Json& s = scene();
    s["title"] = request_.name;
    s["source"] =
        is_generated_scene(request_.source[0]) ? "generated" : fs::path(request_.source[0]).filename().string();
    s["triangles"] = world_->triangles();
    s["objects"] = world_->objects.size();
    s["instances"] = world_->instances.size();
    s["placed_triangles"] = world_->placed_triangles();
    s["lights"] = world_->lights.size();
    if (s.contains("bvh")) return;  // measured by an earlier run
    s["bvh"] = {{"build_seconds", world_->cost.build_seconds}, {"memory_bytes", world_->cost.memory_bytes}};
  }

  std::optional<Error> bake_all() {
    return bake_missing(*this, *world_, configurations_, options_.render, options_.bakes, options_.quiet);
  }

  std::optional<Error> open_all() {
    std::vector<std::string> ids;
    for (const Configuration& c : configurations_) ids.push_back(c.id());
    ids.push_back(kUnclassified);
    for (const std::string& id : ids) {
      auto opened = open_sidecars(*world_, {sidecar_path(id).string()});
      if (!opened) return opened.error();
      open_.push_back({id, std::move(*opened)});
    }
    OpenOptions without_look_ups;
    without_look_ups.look_up = LookUpFirst::never;
    auto alone = open_sidecars(*world_, {sidecar_path(ids.front()).string()}, without_look_ups);
    if (!alone) return alone.error();
    alone_.emplace(std::move(*alone));
    if (!variant("bvh").contains("ways"))
      variant("bvh")["ways"] = describe_ways(
          fastest_ways(*world_, options_.render, false, [&](const ShadowWays& w) { return bvh_caster(w); }));
    for (OpenVariant& v : open_) {
      Json& ways = variant(v.id)["ways"];
      if (ways.is_null())
        ways = describe_ways(fastest_ways(*world_, options_.render, true,
                                          [&](const ShadowWays& w) { return vcd_caster(v.sidecars.objects, w); }));
      if (v.id == kUnclassified)  // what look-ups cost that never answer
        for (Json& kind : ways) kind["look_up"] = true;
      v.ways = ways_of(ways);
    }
    bvh_ways_ = ways_of(variant("bvh")["ways"]);
    scene()["packets"] = {{"bvh", text_of(bvh_ways_)}, {"vcd", text_of(open_[open_.size() - 2].ways)}};
    auto counter = TestCounter::build(*world_);
    if (!counter) return counter.error();
    counter_.emplace(std::move(*counter));
    judge_.emplace(*world_, open_.front().sidecars.objects);
    scene()["judge"] = "exact arithmetic";
    return std::nullopt;
  }

  std::unique_ptr<ShadowCaster> bvh_caster(const ShadowWays& ways) const {
    return std::make_unique<BvhShadows>(*world_, ways);
  }
  std::unique_ptr<ShadowCaster> vcd_caster(const std::vector<Object>& objects, const ShadowWays& ways) const {
    return std::make_unique<SidecarShadows>(*world_, objects, ways);
  }

  Result<Rendered> picture(const std::string& what, const MakeCaster& make) const {
    ProgressLine line(label(what), options_.quiet);
    RenderHooks hooks;
    hooks.stop = interrupted;
    hooks.progress = [&](const RenderProgress& p) { line.update({p.fraction, p.shadow_segments, p.seconds}); };
    return render::render(*world_, options_.render, make, hooks);
  }

  Judge* judge() { return judge_ ? &*judge_ : nullptr; }

  // The BVH's picture first: all others are held against it, and the judge learns from it.
  std::optional<Error> count_all() {
    const auto is_there = [&](const auto& v) { return variant(v.id).contains("segments"); };
    const std::vector<Caster> alone = hierarchy_casters();
    if (variant("bvh").contains("tests") && std::all_of(open_.begin(), open_.end(), is_there) &&
        std::all_of(alone.begin(), alone.end(), is_there))
      return std::nullopt;
    if (auto error = count_bvh()) return error;
    for (const OpenVariant& v : open_) {
      if (variant(v.id).contains("segments")) continue;
      if (auto error = count_variant(v)) return error;
      if (auto error = results_.save()) return error;
    }
    for (const Caster& caster : alone) {
      if (is_there(caster)) continue;
      if (auto error = count_hierarchy(caster)) return error;
      if (auto error = results_.save()) return error;
    }
    return std::nullopt;
  }

  std::optional<Error> count_bvh() {
    const size_t pixels = size_t{options_.render.width} * options_.render.height;
    Census census(*world_, {}, *counter_, bvh_ways_.traced[0], pixels, judge());
    auto rendered = picture("counting, BVH", [&] { return census.caster(); });
    if (!rendered) return stopped();
    bvh_image_ = std::move(rendered->image);
    const CensusPass pass = census.take();
    tests_scale_ = scale_for(pass.pixel_tests);
    Json& v = variant("bvh");
    v["label"] = "BVH";
    v["tests"] = pass.tests;
    scene()["shadow_segments"] = pass.total().segments;
    describe_wrong(v, pass.total());
    if (auto error = write_image(v, "bvh", "shaded", tone_mapped(bvh_image_))) return error;
    return write_counts(v, "bvh", "tests", pass.pixel_tests, tests_scale_, "ray-triangle tests a pixel");
  }

  std::optional<Error> count_variant(const OpenVariant& open) {
    const size_t pixels = size_t{options_.render.width} * options_.render.height;
    Census census(*world_, open.sidecars.objects, *counter_, bvh_ways_.traced[0], pixels, judge());
    const auto rendered = picture("counting, " + open.id, [&] { return census.caster(); });
    if (!rendered) return stopped();
    const CensusPass pass = census.take();
    const KindCounts total = pass.total();
    Json& v = variant(open.id);
    v["tests"] = pass.tests;
    v["fallback_segments"] = total.segments - total.resolved();
    v["resolved_segments"] = total.resolved();
    v["wrong_resolved"] = total.wrong_answered;
    describe_wrong(v, total);
    describe_kinds(v, pass);
    const Difference difference = describe_difference(v, rendered->image);
    if (open.id == kUnclassified) v["label"] = "all cells unclassified", v["identical_image"] = difference.pixels == 0;
    const double most = static_cast<double>(options_.render.pixel_samples) * options_.render.light_samples *
                        static_cast<double>(world_->lights.size());
    for (const auto& error :
         {write_image(v, open.id, "shaded", tone_mapped(rendered->image)),
          write_counts(v, open.id, "tests", pass.pixel_tests, tests_scale_, "ray-triangle tests a pixel"),
          write_counts(v, open.id, "fallback", pass.pixel_open, most, "shadow rays a pixel that needed the BVH"),
          write_image(v, open.id, "difference", amplified_difference(bvh_image_, rendered->image, kAmplify))})
      if (error) return error;
    v["difference_factor"] = kAmplify;
    v["segments"] = total.segments;  // last: it says that this step is done
    return std::nullopt;
  }

  // No BVH is asked, so nothing is counted but wrong answers.
  std::optional<Error> count_hierarchy(const Caster& caster) {
    const size_t pixels = size_t{options_.render.width} * options_.render.height;
    Census census(*world_, caster.make, bvh_ways_.traced[0], pixels, judge());
    const auto rendered = picture("counting, " + caster.id, [&] { return census.caster(); });
    if (!rendered) return stopped();
    const CensusPass pass = census.take();
    const KindCounts total = pass.total();
    Json& v = variant(caster.id);
    v["label"] = caster.label;
    if (!caster.tree.empty()) v["behind"] = caster.tree, v["horizons"] = caster.by_horizons;
    v["fallback_segments"] = 0;
    v["resolved_segments"] = total.segments;
    describe_wrong(v, total);
    describe_kinds(v, pass);
    describe_difference(v, rendered->image);
    v["segments"] = total.segments;  // last, as above
    return std::nullopt;
  }

  Difference describe_difference(Json& v, const Image& image) const {
    const Difference difference = compare(bvh_image_, image);
    v["rmse"] = difference.rmse;
    v["max_difference"] = difference.maximum;
    return difference;
  }

  std::optional<Error> write_image(Json& v, const std::string& id, const char* view, const Image& image) {
    const std::string name = "images/" + request_.name + "-" + id + "-" + view + ".png";
    v["images"][view] = name;
    return write_png(results_.folder() / name, image);
  }
  std::optional<Error> write_counts(Json& v, const std::string& id, const char* view, const std::vector<double>& counts,
                                    double scale, const std::string& caption) {
    return write_image(v, id, view,
                       false_colour(counts, options_.render.width, options_.render.height, scale, caption));
  }

  std::vector<Caster> hierarchy_casters() const {
    std::vector<Caster> all;
    const auto add = [&](const std::string& id, const std::string& label, const std::string& tree,
                         const std::vector<Object>& objects, bool by_horizons) {
      all.push_back({id, label, tree, by_horizons, &objects, [this, &objects, by_horizons] {
                       return std::make_unique<HierarchyShadows>(*world_, objects, by_horizons);
                     }});
    };
    if (have_hierarchies(alone_->objects)) add("hierarchy", "hierarchy alone", {}, alone_->objects, false);
    for (const OpenVariant& v : open_) {
      if (v.id == kUnclassified || !have_hierarchies(v.sidecars.objects)) continue;
      add(v.id + "-hierarchy", v.id + ", hierarchy behind it", v.id, v.sidecars.objects, false);
      if (some_has_horizons(v.sidecars.objects))
        add(v.id + "-horizons", v.id + ", horizons and hierarchy behind it", v.id, v.sidecars.objects, true);
    }
    return all;
  }

  std::vector<Caster> timed_casters() const {
    std::vector<Caster> all = {
        {"bvh", {}, {}, false, nullptr, [&] { return bvh_caster(bvh_ways_); }},
        {kSingle, "BVH, ray by ray", {}, false, nullptr, [&] { return bvh_caster(EmbreeQuery{1}); }}};
    for (const OpenVariant& v : open_)
      all.push_back({v.id, {}, {}, false, nullptr, [&] { return vcd_caster(v.sidecars.objects, v.ways); }});
    for (Caster& caster : hierarchy_casters()) all.push_back(std::move(caster));
    return all;
  }

  // Whole pictures, every variant in turn, again and again.
  std::optional<Error> time_pictures() {
    const std::vector<Caster> casters = timed_casters();
    if (std::all_of(casters.begin(), casters.end(),
                    [&](const Caster& t) { return variant(t.id).contains("render_seconds"); }))
      return std::nullopt;
    std::vector<std::vector<double>> whole(casters.size()), shadow(casters.size());
    Image expected;
    for (int r = 0; r < options_.repetitions; ++r)
      for (size_t i = 0; i < casters.size(); ++i) {
        const auto rendered = picture("timing, round " + std::to_string(r + 1) + " of " +
                                          std::to_string(options_.repetitions) + ", " + casters[i].id,
                                      casters[i].make);
        if (!rendered) return stopped();
        whole[i].push_back(rendered->seconds);
        shadow[i].push_back(rendered->shadow_seconds);
        if (r > 0) continue;
        if (i == 0) expected = rendered->image;
        variant(casters[i].id)["differing_pixels"] = compare(expected, rendered->image).pixels;
      }
    for (size_t i = 0; i < casters.size(); ++i) {
      Json& v = variant(casters[i].id);
      if (!casters[i].label.empty()) v["label"] = casters[i].label;
      v["render_seconds"] = describe_seconds(summarize(casters[i].id, whole[i]), 1);
      v["shadow_seconds"] = describe_seconds(summarize(casters[i].id, shadow[i]), 1);
    }
    return std::nullopt;
  }

  std::optional<Error> time_kinds() {
    if (kinds_are_timed()) return std::nullopt;
    RenderSettings sparse = options_.render;  // one camera ray for sixteen: enough segments, and all kinds of them
    sparse.pixel_samples = std::max(1u, sparse.pixel_samples / 16);
    std::array<uint64_t, kSegmentKinds> all{};
    const auto kinds = split_by_kind(*world_, record(*world_, sparse), options_.segments_of_kind, all);
    std::vector<SidecarVariant> variants;
    for (const OpenVariant& v : open_)
      if (v.id != kUnclassified) variants.push_back({v.id, &v.sidecars.objects, v.ways});
    Json measured = Json::array();
    for (size_t k = 0; k < kSegmentKinds; ++k) {
      if (kinds[k].segment_count() == 0) continue;
      if (interrupted()) return stopped();
      ProgressLine line(label("timing, " + std::string(segment_kind_name(static_cast<SegmentKind>(k)))),
                        options_.quiet);
      line.update({static_cast<double>(k) / kSegmentKinds, kinds[k].segment_count(), 0});
      measured.push_back(measure_kind(*world_, static_cast<SegmentKind>(k), kinds[k], variants, *counter_,
                                      bvh_ways_.traced[0], judge(), options_.repetitions));
      measured.back()["share"] =
          static_cast<double>(all[k]) / static_cast<double>(std::accumulate(all.begin(), all.end(), uint64_t{0}));
    }
    scene()["kinds"] = measured;
    return std::nullopt;
  }

  bool kinds_are_timed() {
    if (!scene().contains("kinds")) return false;
    for (const Json& kind : scene()["kinds"])
      for (const OpenVariant& v : open_)
        if (v.id != kUnclassified &&
            std::none_of(kind["vcd"].begin(), kind["vcd"].end(), [&](const Json& e) { return e["variant"] == v.id; }))
          return false;
    return true;
  }

  // Single calls and wavefronts, of all that ask no Embree.
  std::optional<Error> time_paths() {
    std::vector<PathWay> ways;
    for (const Caster& caster : hierarchy_casters())
      ways.push_back({caster.id, SidecarPaths(*world_, *caster.objects, caster.by_horizons)});
    const Json& there = scene()["paths"]["wrong"];
    if (ways.empty() || std::ranges::all_of(ways, [&](const PathWay& w) { return there.contains(w.name); }))
      return std::nullopt;
    const ProgressLine line(label("timing paths"), options_.quiet);
    const auto high = HighQualityCasters::build(*world_);
    if (!high) return high.error();
    const PathBench bench(*world_, *high, ways, alone_->objects, options_.repetitions);
    const PathComparison compared = bench.compare("all", trace_paths(*world_, {.paths = options_.paths}));
    if (interrupted()) return stopped();
    scene()["paths"] = describe(compared, ways);
    return std::nullopt;
  }

  static constexpr float kAmplify = 20;

  const PaperRunOptions& options_;
  const SceneRequest& request_;
  std::optional<World> world_;
  std::vector<Configuration> configurations_;
  std::vector<OpenVariant> open_;
  std::optional<WorldSidecars> alone_;  // of the first, with no look-ups
  std::optional<TestCounter> counter_;
  std::optional<Judge> judge_;
  ShadowWays bvh_ways_;
  Image bvh_image_;
  double tests_scale_ = 1;
};

}  // namespace

std::vector<int> run_paper(const PaperRunOptions& options, Results& results) {
  std::vector<int> codes;
  for (const SceneRequest& request : options.scenes) {
    SceneRun scene(options, request, results);
    const auto error = scene.run();
    codes.push_back(error ? exit_code(error->code) : kExitOk);
    if (!error) continue;
    print_error(error->message);
    if (!interrupted()) {
      results.scene(request.name)["status"] = "failed";
      results.scene(request.name)["error"] = error->message;
    }
    if (const auto unsaved = results.save()) print_error(unsaved->message);
    if (interrupted()) break;
  }
  return codes;
}

}  // namespace vcd::bench
