#include "demand_run.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>

#include <vcd/baker/demand.h>
#include <vcd/baker/referee.h>
#include <vcd/library/light_demand.h>
#include <vcd/writer/demand.h>

#include "common/describe.h"
#include "common/progress.h"
#include "common/seconds_since.h"
#include "machine.h"
#include "paper_run.h"
#include "render/recorded.h"
#include "render/recording.h"
#include "render/sidecars.h"
#include "render/turned.h"
#include "timing.h"

namespace vcd::bench {

using namespace baker;
using namespace library;
using namespace tools;
using namespace render;
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kRecordedSeed = 0xDE3A, kSampleSeed = 0x5EED;
constexpr size_t kJudgedAtOnce = size_t{1} << 22;
constexpr size_t kSample = size_t{1} << 19;  // of a picture's rays, to be judged; one in eight of them is

// Who asks: where camera and lights stand, turned from where the scene has them.
struct Case {
  const char* name;
  double camera, lights;
};
constexpr Case kCases[] = {{"same camera, another seed", 0, 0},
                           {"camera turned by 30 degrees", 30, 0},
                           {"camera turned by 90 degrees", 90, 0},
                           {"camera turned by 180 degrees", 180, 0},
                           {"lights turned by 30 degrees", 0, 30}};

struct Baked {
  std::string name;
  double seconds;
  uint64_t file_bytes;
  uint32_t depth;
  WorldSidecars sidecars;
};

// Shadow rays and those that look-ups leave unclassified.
struct Left {
  uint64_t ground = 0, ground_left = 0, all = 0, all_left = 0;
};

class CountingShadows : public ShadowCaster {
 public:
  CountingShadows(const World& world, std::span<const Object> objects, Left& sum, std::mutex& mutex)
      : shadows_(world, objects, {}), sum_(sum), mutex_(mutex) {}
  ~CountingShadows() override {
    const std::lock_guard lock(mutex_);
    sum_.ground += left_.ground, sum_.ground_left += left_.ground_left;
    sum_.all += left_.all, sum_.all_left += left_.all_left;
  }
  void cast(const Bundle& bundle, std::span<uint8_t> blocked) override {
    const auto answers = std::span(answers_).first(bundle.segments.size());
    shadows_.look_up(bundle, answers);
    const auto left = static_cast<uint64_t>(std::ranges::count(answers, Visibility::unclassified));
    left_.all += answers.size(), left_.all_left += left;
    if (bundle.surface == kGroundSurface) left_.ground += answers.size(), left_.ground_left += left;
    std::ranges::fill(blocked, uint8_t{0});
  }

 private:
  SidecarShadows shadows_;
  Left left_, &sum_;
  std::mutex& mutex_;
  std::array<Visibility, kMaxBundle> answers_;
};

double share(double part, double whole) { return whole > 0 ? part / whole : 0; }

class DemandRun {
 public:
  DemandRun(const DemandRunOptions& options, World& world)
      : options_(options), world_(world), view_(world.view), lights_(world.lights) {}

  std::optional<Error> run() {
    for (const auto step : {&DemandRun::bake_all, &DemandRun::ask_all, &DemandRun::judge_many})
      if (auto error = (this->*step)()) return error;
    return std::nullopt;
  }

  Json report() const {
    Json json{{"tool", "vc-bench"},
              {"version", VCD_VERSION},
              {"machine", machine_description()},
              {"scene", options_.scene},
              {"budget_mb", options_.budget_mb},
              {"repetitions", options_.repetitions},
              {"sidecars", Json::array()},
              {"cases", cases_},
              {"judged", judged_}};
    for (const Baked& b : baked_)
      json["sidecars"].push_back(
          {{"name", b.name}, {"depth", b.depth}, {"file_bytes", b.file_bytes}, {"bake_seconds", b.seconds}});
    return json;
  }

 private:
  Error stopped() const { return {ErrorCode::runtime, options_.scene + ": interrupted"}; }
  void place(const Case& c) {
    world_.view = view_, world_.lights = lights_;  // turns begin where the scene has them
    auto view = turned_view(world_, c.camera);
    auto lights = turned_lights(world_, c.lights);
    world_.view = view, world_.lights = std::move(lights);
  }
  RenderSettings with_seed(uint64_t seed) const {
    RenderSettings settings = options_.render;
    settings.seed ^= seed;
    return settings;
  }

  Result<Demand> recorded(std::span<const double> cameras) {
    std::vector<Demand> demands;
    for (const double degrees : cameras) {
      place({"", degrees, 0});
      RenderHooks hooks;
      hooks.stop = interrupted;
      auto demand = demand_of_picture(world_, with_seed(kRecordedSeed), options_.most_recorded / cameras.size(), hooks);
      if (!demand) return demand.error();
      demands.push_back(std::move(*demand));
    }
    return merge(demands);
  }

  // As vc-bake --for-lights: no camera, and the ground below all objects.
  Result<Demand> of_lights() {
    place({"", 0, 0});
    std::vector<SceneLight> lights;
    const auto vector = [](Vec3 v) { return SceneLight::Vector{v.x, v.y, v.z}; };
    for (const Light& light : world_.lights) {
      const Quad& quad = light.quad;
      SceneLight& scene_light = lights.emplace_back();
      scene_light.shape = SceneLight::Shape::rectangle;
      scene_light.half_edges = {vector(quad.edge_u * 0.5f), vector(quad.edge_v * 0.5f)};
      scene_light.position = vector(quad.corner + quad.edge_u * 0.5f + quad.edge_v * 0.5f);
      scene_light.direction = vector(quad.normal);
    }
    std::vector<LitInstance> instances;
    for (const WorldInstance& instance : world_.instances) {
      LitInstance& lit = instances.emplace_back(LitInstance{&world_.objects[instance.object].mesh});
      if (world_.single()) continue;
      for (size_t i = 0; i < 3; ++i) {
        const SceneLight::Vector column = vector(instance.to_world.column[i]),
                                 offset = vector(instance.to_world.offset);
        for (size_t row = 0; row < 3; ++row)
          lit.to_scene[4 * row + i] = column[row], lit.to_scene[4 * row + 3] = offset[row];
      }
    }
    const Vec3 up = world_.ground.normal;
    const Axis axis = up.x > 0.9f ? Axis::x : up.y > 0.9f ? Axis::y : Axis::z;
    return demand_of_lights(instances, lights, axis, options_.most_recorded);
  }

  std::optional<Error> bake_all() {
    std::error_code failed;
    fs::create_directories(options_.folder, failed);
    if (failed) return Error{ErrorCode::io, options_.folder + ": cannot be made: " + failed.message()};
    constexpr double kOne[] = {0}, kThree[] = {0, 120, 240};
    const auto one = recorded(kOne);
    if (!one) return one.error();
    const auto three = recorded(kThree);
    if (!three) return three.error();
    const auto lights = of_lights();
    if (!lights) return lights.error();
    for (const Method method : {Method::proven, Method::hybrid}) {
      if (method == Method::hybrid && options_.proven_only) continue;
      const std::tuple<const char*, const Demand*> kinds[] = {
          {"any scene", nullptr}, {"one camera", &*one}, {"three cameras", &*three}, {"lights alone", &*lights}};
      for (const auto& [name, demand] : kinds)
        if (auto error = bake_one(name, method, demand)) return error;
    }
    return std::nullopt;
  }

  std::optional<Error> bake_one(const std::string& kind, Method method, const Demand* demand) {
    const std::string name = kind + ", " + method_name(method);
    BakeOptions bake;
    bake.depth = options_.depth, bake.method = method, bake.threads = options_.render.threads, bake.stop = interrupted;
    if (demand) {
      bake.depth = 0, bake.demand = demand;
      bake.budget_bytes = static_cast<uint64_t>(options_.budget_mb * 1048576);
    }
    const fs::path path = fs::path(options_.folder) / ("sidecar-" + std::to_string(baked_.size()) + ".vcd");
    ProgressLine line("baking for " + name, options_.quiet);
    const auto start = std::chrono::steady_clock::now();
    const auto baked =
        bake_world(world_, bake, path, [&](const WorldObject&, const BakeProgress& p) { line.update(p); });
    if (interrupted()) return stopped();
    if (!baked) return baked.error();
    const double seconds = seconds_since(start);
    auto opened = open_sidecars(world_, {path.string()});
    if (!opened) return opened.error();
    if (!have_hierarchies(opened->objects))
      return Error{ErrorCode::runtime, path.string() + ": has no hierarchy; give a larger --budget-mb"};
    baked_.push_back({name, seconds, baked->file_bytes, baked->depth, std::move(*opened)});
    return std::nullopt;
  }

  std::optional<Error> ask_all() {
    OpenOptions no_look_ups;
    no_look_ups.look_up = LookUpFirst::never;
    const std::string first = (fs::path(options_.folder) / "sidecar-0.vcd").string();
    auto alone = open_sidecars(world_, {first}, no_look_ups);
    if (!alone) return alone.error();
    for (const Case& c : kCases) {
      place(c);
      Json json{{"name", c.name}, {"camera_degrees", c.camera}, {"lights_degrees", c.lights}};
      if (auto error = time_all(*alone, json)) return error;
      const auto sample = demand_of_picture(world_, with_seed(kSampleSeed), kSample);
      if (!sample) return sample.error();
      for (size_t i = 0; i < baked_.size(); ++i)
        if (auto error = count(baked_[i], *sample, json["sidecars"][i])) return error;
      cases_.push_back(std::move(json));
    }
    return std::nullopt;
  }

  // What a sidecar leaves of the picture's rays, and what is wrong of a sample of them.
  std::optional<Error> count(const Baked& baked, const Demand& sample, Json& json) const {
    Left left;
    std::mutex mutex;
    RenderHooks hooks;
    hooks.stop = interrupted;
    const auto counted = render::render(
        world_, options_.render,
        [&] { return std::make_unique<CountingShadows>(world_, baked.sidecars.objects, left, mutex); }, hooks);
    if (!counted) return stopped();
    DemandReport sum;
    for (size_t i = 0; i < world_.objects.size(); ++i) {
      const auto asked = sample.find(world_.objects[i].mesh.geometry_hash);
      if (asked == sample.end()) continue;
      const auto report = judge_demand(world_.objects[i].mesh, baked.sidecars.objects[i].record(), tree_of(baked, i),
                                       asked->second, interrupted);
      if (!report) return report.error();
      sum.segments += report->segments, sum.weight += report->weight, sum.wrong += report->wrong;
      sum.answered += report->answered, sum.answered_weight += report->answered_weight;
    }
    json["ground_rays"] = left.ground, json["ground_left"] = left.ground_left;
    json["rays"] = left.all, json["left"] = left.all_left;
    json["ground_left_share"] = share(static_cast<double>(left.ground_left), static_cast<double>(left.ground));
    json["left_share"] = share(static_cast<double>(left.all_left), static_cast<double>(left.all));
    json["answered_of_box"] = sum.share();
    json["judged"] = sum.answered, json["wrong"] = sum.wrong;
    json["wrong_bound_95"] = upper_bound_95(sum.wrong, sum.answered);
    return std::nullopt;
  }

  TreeView tree_of(const Baked& baked, size_t object) const {
    const GeometryHash& hash = world_.objects[object].mesh.geometry_hash;
    const auto& objects = baked.sidecars.files[0].contents().objects;
    return std::ranges::find_if(objects, [&](const ObjectContents& o) { return o.record->geometry_hash == hash; })
        ->tree;
  }

  // Further pictures of the scene's own camera, until so many segments have been judged exactly with each sidecar.
  std::optional<Error> judge_many() {
    if (options_.judged == 0) return std::nullopt;
    place(kCases[0]);
    std::vector<Referee> referees;
    for (const WorldObject& object : world_.objects) referees.emplace_back(object.mesh);
    judged_ = Json::array();
    for (const Baked& b : baked_)
      judged_.push_back({{"name", b.name}, {"segments", 0u}, {"answered", 0u}, {"wrong", 0u}});
    ProgressLine line("judging", options_.quiet);
    for (uint64_t seed = 1, segments = 0; segments < options_.judged; ++seed) {
      const auto asked = demand_of_picture(world_, with_seed(kSampleSeed + seed), kJudgedAtOnce);
      if (!asked) return asked.error();
      for (size_t o = 0; o < world_.objects.size(); ++o) {
        const auto found = asked->find(world_.objects[o].mesh.geometry_hash);
        if (found == asked->end()) continue;
        if (interrupted()) return stopped();
        judge(found->second, o, referees[o]);
        segments += found->second.size();
      }
      line.update({static_cast<double>(segments) / static_cast<double>(options_.judged), segments, 0});
    }
    return std::nullopt;
  }
  void judge(const std::vector<AskedSegment>& asked, size_t object, const Referee& referee) {
    std::vector<Segment> segments;
    for (const AskedSegment& a : asked) segments.push_back(a.segment);
    std::vector<uint8_t> truth(segments.size());
    referee.occluded(segments, truth);
    for (size_t b = 0; b < baked_.size(); ++b) {
      uint64_t answered = 0, wrong = 0;
      for (size_t i = 0; i < segments.size(); ++i) {
        const Visibility answer = baked_[b].sidecars.objects[object].classify(segments[i]);
        if (answer == Visibility::unclassified) continue;
        ++answered, wrong += (answer == Visibility::blocked) != (truth[i] != 0);
      }
      Json& sum = judged_[b];
      sum["segments"] = sum["segments"].get<uint64_t>() + segments.size();
      sum["answered"] = sum["answered"].get<uint64_t>() + answered;
      sum["wrong"] = sum["wrong"].get<uint64_t>() + wrong;
      sum["wrong_bound_95"] = upper_bound_95(sum["wrong"].get<uint64_t>(), sum["answered"].get<uint64_t>());
    }
  }

  // Shadow seconds of one picture, interleaved: Embree, the hierarchy alone, and each sidecar's look-ups before it.
  std::optional<Error> time_all(const WorldSidecars& alone, Json& json) const {
    const ShadowWays ways = fastest_ways(world_, options_.render, false,
                                         [&](const ShadowWays& w) { return std::make_unique<BvhShadows>(world_, w); });
    std::vector<MakeCaster> casters = {[&] { return std::make_unique<BvhShadows>(world_, ways); },
                                       [&] { return std::make_unique<HierarchyShadows>(world_, alone.objects); }};
    for (const Baked& b : baked_)
      casters.push_back([&] { return std::make_unique<HierarchyShadows>(world_, b.sidecars.objects); });
    std::vector<std::vector<double>> seconds(casters.size());
    ProgressLine line(std::string("timing, ") + json["name"].get<std::string>(), options_.quiet);
    for (int r = 0; r < options_.repetitions; ++r)
      for (size_t i = 0; i < casters.size(); ++i) {
        RenderHooks hooks;
        hooks.stop = interrupted;
        const auto rendered = render::render(world_, options_.render, casters[i], hooks);
        if (!rendered) return stopped();
        seconds[i].push_back(rendered->shadow_seconds);
      }
    const double embree = summarize("", seconds[0]).median;
    json["embree"] = text_of(ways), json["embree_seconds"] = embree;
    json["hierarchy_alone_speedup"] = embree / summarize("", seconds[1]).median;
    json["sidecars"] = Json::array();
    for (size_t i = 0; i < baked_.size(); ++i) {
      const Timing t = summarize(baked_[i].name, seconds[i + 2]);
      json["sidecars"].push_back({{"name", t.name}, {"shadow_seconds", t.median}, {"speedup", embree / t.median}});
    }
    return std::nullopt;
  }

  const DemandRunOptions& options_;
  World& world_;
  const View view_;
  const std::vector<Light> lights_;
  std::vector<Baked> baked_;
  Json cases_ = Json::array(), judged_;
};

void print(const Json& report) {
  std::printf("%s; speed against Embree's best packets, hierarchy behind look-ups, %d interleaved repetitions\n",
              report["machine"].get<std::string>().c_str(), report["repetitions"].get<int>());
  for (const Json& s : report["sidecars"])
    std::printf("  %-32s depth %d, %6.1f MiB, baked in %.1f s\n", s["name"].get<std::string>().c_str(),
                s["depth"].get<int>(), s["file_bytes"].get<double>() / 1048576, s["bake_seconds"].get<double>());
  for (const Json& c : report["cases"]) {
    std::printf("%s: the hierarchy alone %.2f times\n", c["name"].get<std::string>().c_str(),
                c["hierarchy_alone_speedup"].get<double>());
    for (const Json& s : c["sidecars"])
      std::printf(
          "  %-32s %5.2f times; left %5.2f %% of ground rays, %5.2f %% of all; of rays into a box %5.2f %% "
          "answered, %llu of %llu wrong\n",
          s["name"].get<std::string>().c_str(), s["speedup"].get<double>(), 100 * s["ground_left_share"].get<double>(),
          100 * s["left_share"].get<double>(), 100 * s["answered_of_box"].get<double>(),
          s["wrong"].get<unsigned long long>(), s["judged"].get<unsigned long long>());
  }
  if (report["judged"].is_null()) return;
  std::printf("judged exactly, of further pictures of the same camera\n");
  for (const Json& s : report["judged"])
    std::printf("  %-32s %llu of %llu answers wrong, of %llu segments\n", s["name"].get<std::string>().c_str(),
                s["wrong"].get<unsigned long long>(), s["answered"].get<unsigned long long>(),
                s["segments"].get<unsigned long long>());
}

}  // namespace

int run_demand(const DemandRunOptions& options) {
  const auto fail = [](const Error& error) { return print_error(error.message), exit_code(error.code); };
  auto request = parse_scene_request(options.scene, {});
  if (!request) return fail(request.error());
  request->options.files.ingest = options.ingest;
  auto world = load_world(request->source, request->options, options.quiet);
  if (!world) return fail(world.error());
  catch_interruptions();
  DemandRun run(options, *world);
  if (const auto error = run.run()) return fail(*error);
  const Json report = run.report();
  if (options.format == OutputFormat::json) print_json(report);
  else print(report);
  return kExitOk;
}

}  // namespace vcd::bench
