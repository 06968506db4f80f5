#include "paths.h"

#include <algorithm>
#include <cstdio>
#include <tuple>

#include <vcd/runtime/scene.h>

#include "common/describe.h"
#include "high_quality.h"
#include "machine.h"
#include "paper_run.h"
#include "render/census.h"
#include "render/judge.h"
#include "render/path_rays.h"
#include "render/shadows.h"
#include "render/sidecars.h"
#include "timing.h"

namespace vcd::bench {

using namespace baker;
using namespace tools;
using namespace render;
namespace {

constexpr size_t kWavefront = 4096;  // paths that advance together
constexpr size_t kJudged = 100'000;  // segments of each kind that the referee judges, at most

// Rays of one kind, in the order in which they are asked; and the arrays that a renderer would ask them in.
struct Rays {
  std::vector<Segment> segments;
  std::vector<uint32_t> origins;     // an instance or kNoInstance
  std::vector<uint32_t> primitives;  // of it, or kNoPrimitive
  std::vector<From> from;
  struct Array {
    size_t first, count;
  };
  std::vector<Array> arrays;  // neighbours that begin alike, at most kWavefront

  void add(const PathRay& ray) {
    segments.push_back(ray.segment), from.push_back(ray.from), primitives.push_back(ray.primitive);
    origins.push_back(ray.surface == kGroundSurface ? kNoInstance : ray.surface);
  }
  void cut() {
    for (size_t i = 0; i < segments.size(); ++i) {
      if (arrays.empty() || from[i] != from[arrays.back().first] || arrays.back().count == kWavefront)
        arrays.push_back({i, 0});
      ++arrays.back().count;
    }
  }
};

// The same rays twice: path by path, and as wavefronts.
struct RayOrders {
  Rays paths, wavefronts;
};

template <class Keep>
RayOrders orders_of(const std::vector<PathRay>& rays, const Keep& keep) {
  std::vector<PathRay> kept;
  std::copy_if(rays.begin(), rays.end(), std::back_inserter(kept), keep);
  RayOrders orders;
  for (const PathRay& ray : kept) orders.paths.add(ray);
  std::stable_sort(kept.begin(), kept.end(), [](const PathRay& a, const PathRay& b) {
    const auto key = [](const PathRay& r) { return std::tuple(r.path / kWavefront, r.bounce, r.from); };
    return key(a) < key(b);
  });
  for (const PathRay& ray : kept) orders.wavefronts.add(ray);
  orders.wavefronts.cut();
  return orders;
}

// One object, or a scene of instances, asked without a fallback; as the sidecars were opened. by_horizons: those are
// asked first of what begins on the object.
class Alone {
 public:
  Alone(std::string name, const World& world, WorldSidecars sidecars, bool by_horizons)
      : name_(std::move(name)), sidecars_(std::move(sidecars)), by_horizons_(by_horizons) {
    if (world.single()) object_ = sidecars_.objects[0];
    else scene_.emplace(scene_of(world, sidecars_.objects));
  }
  const std::string& name() const { return name_; }

  bool occluded(const Rays& rays, size_t i) const {
    if (object_ && by_horizons_ && rays.from[i] == From::self)
      return object_->occluded_self(rays.segments[i], rays.primitives[i]);
    if (object_) return object_->occluded(rays.segments[i], rays.from[i]);
    return scene_->occluded(rays.segments[i], query(rays, {i, 1}));
  }
  // A bit a segment, as Object::occluded() gives them.
  void occluded(const Rays& rays, Rays::Array array, std::span<uint64_t> blocked) const {
    const auto segments = std::span(rays.segments).subspan(array.first, array.count);
    if (object_ && by_horizons_ && rays.from[array.first] == From::self)
      object_->occluded_self(segments, std::span(rays.primitives).subspan(array.first, array.count), blocked);
    else if (object_) object_->occluded(segments, blocked, rays.from[array.first]);
    else scene_->occluded(segments, blocked, query(rays, array));
  }

  // Look-ups, and rtcOccluded1 for what they leave.
  bool occluded(const Rays& rays, size_t i, RTCScene casters, const EmbreeInstances& instances) const {
    RTCRay ray = to_ray(rays.segments[i]);
    if (object_) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      occluded1(*object_, casters, &context, &ray);
    } else {
      occluded1(*scene_, instances, &ray, query(rays, {i, 1}));
    }
    return ray.tfar < 0;
  }

  std::span<const Object> objects() const { return sidecars_.objects; }
  bool by_horizons() const { return by_horizons_; }

 private:
  SceneQuery query(const Rays& rays, Rays::Array array) const {
    SceneQuery query{0xFFFFFFFF, std::span(rays.origins).subspan(array.first, array.count)};
    if (by_horizons_) query.primitives = std::span(rays.primitives).subspan(array.first, array.count);
    return query;
  }

  std::string name_;
  WorldSidecars sidecars_;
  bool by_horizons_;
  std::optional<Object> object_;
  std::optional<Scene> scene_;
};

bool occluded_by_bvh(RTCScene scene, const Segment& segment) {
  uint8_t blocked;
  occluded(scene, {1}, std::span(&segment, 1), &blocked);
  return blocked != 0;
}

// Ways of one use, and the same of sidecars.
struct Times {
  std::vector<Timing> embree, vcd;
};

struct Comparison {
  std::string name;
  // differ: answers of the hierarchy that are not Embree's. wrong: in exact arithmetic, of the first `judged`.
  uint64_t segments = 0, blocked = 0, differ = 0, judged = 0, wrong_embree = 0, wrong_hierarchy = 0;
  uint64_t wrong_horizons = 0;  // of all segments: held against the hierarchy's answers
  Times single, wavefronts;
};

class Bench {
 public:
  // alone: the hierarchy first, with no look-up.
  Bench(const World& world, const HighQualityCasters& high, const std::vector<Alone>& alone, int repetitions)
      : world_(world), high_(high), alone_(alone), judge_(world, alone[0].objects()), repetitions_(repetitions) {
    for (const WorldInstance& instance : world.instances)
      objects_.push_back(world.objects[instance.object].tracer.scene());
  }

  Comparison compare(const std::string& name, const RayOrders& rays) const {
    Comparison result;
    result.name = name;
    judge(rays.paths, result);
    result.single = time(single_embree(rays.paths), single_vcd(rays.paths));
    result.wavefronts = time(wavefront_embree(rays.wavefronts), wavefront_vcd(rays.wavefronts));
    return result;
  }

 private:
  using Variants = std::vector<Variant>;
  static constexpr std::pair<const char*, bool> kBuilds[] = {{"", false}, {", build of high quality", true}};

  void judge(const Rays& rays, Comparison& result) const {
    result.segments = rays.segments.size();
    result.judged = std::min(kJudged, rays.segments.size());
    for (size_t i = 0; i < rays.segments.size(); ++i) {
      const bool embree = occluded_by_bvh(casters(false), rays.segments[i]), ours = alone_[0].occluded(rays, i);
      result.blocked += embree, result.differ += embree != ours;
      if (alone_.back().by_horizons()) result.wrong_horizons += alone_.back().occluded(rays, i) != ours;
      if (i >= result.judged) continue;
      const bool truth = judge_.blocked(rays.segments[i]);
      result.wrong_embree += embree != truth, result.wrong_hierarchy += ours != truth;
    }
  }

  Times time(const Variants& embree, const Variants& vcd) const {
    Variants all = embree;
    all.insert(all.end(), vcd.begin(), vcd.end());
    const std::vector<Timing> timings = time_interleaved(all, repetitions_);
    const auto middle = timings.begin() + static_cast<std::ptrdiff_t>(embree.size());
    return {{timings.begin(), middle}, {middle, timings.end()}};
  }

  RTCScene casters(bool high) const { return high ? high_.scene() : world_.shadow_casters(); }

  // ask(i) -> bool, of each ray.
  template <class Ask>
  Variant one_by_one(std::string name, const Rays& rays, Ask ask) const {
    return {std::move(name), [this, &rays, ask] {
              uint64_t blocked = 0;
              for (size_t i = 0; i < rays.segments.size(); ++i) blocked += ask(i);
              sink_ = blocked;
            }};
  }

  Variants single_embree(const Rays& rays) const {
    Variants variants;
    for (const auto& [build, high] : kBuilds)
      variants.push_back(
          one_by_one(std::string("rtcOccluded1") + build, rays,
                     [&rays, scene = casters(high)](size_t i) { return occluded_by_bvh(scene, rays.segments[i]); }));
    return variants;
  }

  Variants single_vcd(const Rays& rays) const {
    Variants variants = {one_by_one("look-ups, then rtcOccluded1", rays, [this, &rays](size_t i) {
      return alone_[0].occluded(rays, i, casters(false), EmbreeInstances{objects_, {1}});
    })};
    for (const Alone& way : alone_)
      variants.push_back(one_by_one(way.name(), rays, [&way, &rays](size_t i) { return way.occluded(rays, i); }));
    return variants;
  }

  Variants wavefront_embree(const Rays& rays) const {
    Variants variants;
    for (const auto& [build, high] : kBuilds)
      for (const EmbreeQuery& way : world_.ways_to_trace())
        if (way.width > 1)
          variants.push_back({name_of(way) + build, [&rays, way, scene = casters(high)] {
                                uint8_t blocked[kWavefront];
                                for (const auto& [first, count] : rays.arrays)
                                  occluded(scene, way, std::span(rays.segments).subspan(first, count), blocked);
                              }});
    return variants;
  }

  Variants wavefront_vcd(const Rays& rays) const {
    Variants variants;
    for (const Alone& way : alone_)
      variants.push_back({way.name(), [&rays, &way] {
                            uint64_t blocked[kWavefront / 64];
                            for (const Rays::Array& array : rays.arrays) way.occluded(rays, array, blocked);
                          }});
    return variants;
  }

  const World& world_;
  const HighQualityCasters& high_;
  const std::vector<Alone>& alone_;
  std::vector<RTCScene> objects_;  // of instances
  Judge judge_;
  int repetitions_;
  mutable volatile uint64_t sink_ = 0;  // keeps the answers from being optimised away
};

Json describe(const Times& times, uint64_t segments) {
  const Timing& best = fastest(times.embree);
  return {{"best_embree", best.name},
          {"embree", describe(times.embree, best, segments)},
          {"vcd", describe(times.vcd, best, segments)}};
}

Json describe(const Comparison& c) {
  return {{"name", c.name},
          {"segments", c.segments},
          {"blocked", c.blocked},
          {"differ", c.differ},
          {"judged", c.judged},
          {"wrong_embree", c.wrong_embree},
          {"wrong_hierarchy", c.wrong_hierarchy},
          {"wrong_horizons", c.wrong_horizons},
          {"single_calls", describe(c.single, c.segments)},
          {"wavefronts", describe(c.wavefronts, c.segments)}};
}

void print(const char* use, const Times& times, uint64_t segments) {
  std::printf(" %s\n", use);
  for (const auto* group : {&times.embree, &times.vcd}) print_timings(*group, fastest(times.embree), segments);
}

void print(const Comparison& c) {
  using Count = unsigned long long;
  std::printf("%s: %llu segments, %.2f %% of them blocked; %llu answers of the hierarchy differ from Embree's\n",
              c.name.c_str(), Count{c.segments}, 100 * static_cast<double>(c.blocked) / static_cast<double>(c.segments),
              Count{c.differ});
  std::printf("  in exact arithmetic, of %llu: Embree wrong %llu times, the hierarchy %llu times\n", Count{c.judged},
              Count{c.wrong_embree}, Count{c.wrong_hierarchy});
  if (c.wrong_horizons > 0) std::printf("  horizons differ from the hierarchy %llu times\n", Count{c.wrong_horizons});
  print("single calls, path by path", c.single, c.segments);
  print("wavefronts of 4096 paths", c.wavefronts, c.segments);
}

Result<std::vector<Alone>> open_alone(const World& world, const std::vector<std::string>& paths) {
  std::vector<Alone> alone;
  for (const auto& [name, look_up, by_horizons] :
       {std::tuple("hierarchy", LookUpFirst::never, false),
        std::tuple("look-ups, then hierarchy", LookUpFirst::always, false),
        std::tuple("look-ups as baked, then hierarchy", LookUpFirst::as_baked, false),
        std::tuple("look-ups as baked and horizons, then hierarchy", LookUpFirst::as_baked, true)}) {
    OpenOptions options;
    options.look_up = look_up;
    auto sidecars = open_sidecars(world, paths, options);
    if (!sidecars) return sidecars.error();
    for (const Object& object : sidecars->objects)
      if (!object.has_hierarchy())
        return Error{ErrorCode::usage, paths[0] + ": without a hierarchy of triangles; bake it again"};
    if (by_horizons && std::ranges::none_of(sidecars->objects, &Object::has_horizons)) continue;
    alone.emplace_back(name, world, std::move(*sidecars), by_horizons);
  }
  return alone;
}

}  // namespace

int run_paths(const PathsOptions& options) {
  const auto fail = [](const Error& error) { return print_error(error.message), exit_code(error.code); };
  const auto world = world_of(options);
  if (!world) return fail(world.error());
  const auto alone = open_alone(*world, options.sidecars);
  if (!alone) return fail(alone.error());
  const auto high = HighQualityCasters::build(*world);
  if (!high) return fail(high.error());

  const Bench bench(*world, *high, *alone, options.repetitions);
  const std::vector<PathRay> rays = trace_paths(*world, {options.points, options.bounces, 7});
  std::vector<Comparison> comparisons;
  const auto add = [&](const std::string& name, const auto& keep) {
    const RayOrders orders = orders_of(rays, keep);
    if (!orders.paths.segments.empty()) comparisons.push_back(bench.compare(name, orders));
  };
  add("all", [](const PathRay&) { return true; });
  for (size_t k = 0; k < kSegmentKinds; ++k) {
    const auto kind = static_cast<SegmentKind>(k);
    add(segment_kind_name(kind), [&](const PathRay& r) { return segment_kind(*world, r.surface, r.segment) == kind; });
  }
  if (comparisons.empty()) return fail({ErrorCode::usage, options.scene + ": no path casts a shadow ray"});

  if (options.format == OutputFormat::json) {
    Json json{{"tool", "vc-bench"},
              {"version", VCD_VERSION},
              {"machine", machine_description()},
              {"repetitions", options.repetitions},
              {"scene", options.scene},
              {"instances", world->instances.size()},
              {"bounces", options.bounces},
              {"sidecars", options.sidecars},
              {"kinds", Json::array()}};
    for (const Comparison& c : comparisons) json["kinds"].push_back(describe(c));
    print_json(json);
    return kExitOk;
  }
  std::printf("%s, one thread, %d interleaved repetitions: medians (minimum to maximum)\n",
              machine_description().c_str(), options.repetitions);
  for (const Comparison& c : comparisons) print(c);
  return kExitOk;
}

}  // namespace vcd::bench
