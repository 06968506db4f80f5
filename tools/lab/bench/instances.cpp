#include "instances.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <random>

#include <vcd/runtime/scene.h>

#include "common/describe.h"
#include "machine.h"
#include "paper_run.h"
#include "render/recording.h"
#include "render/shadows.h"
#include "render/sidecars.h"
#include "timing.h"

namespace vcd::bench {

using namespace tools;
using namespace render;
namespace {

constexpr size_t kArray = 256;  // segments of one call at most

// Bundles of one kind, and their segments in any order.
struct Rays {
  const World* world;
  std::vector<Bundle> bundles;  // point into a recording
  std::vector<Segment> segments;
  std::vector<uint32_t> origins;  // by segment: an instance or kNoInstance

  void add(const Bundle& bundle) {
    bundles.push_back(bundle);
    segments.insert(segments.end(), bundle.segments.begin(), bundle.segments.end());
    origins.insert(origins.end(), bundle.segments.size(),
                   bundle.surface == kGroundSurface ? kNoInstance : bundle.surface);
  }
  void shuffle(uint64_t seed) {
    std::mt19937_64 random(seed);
    for (size_t i = segments.size(); i > 1; --i) {
      const size_t other = random() % i;
      std::swap(segments[i - 1], segments[other]);
      std::swap(origins[i - 1], origins[other]);
    }
    bundles.clear();
  }
  // Calls of arrays: a bundle each, or whatever comes next.
  template <class Visit>
  void in_parts(const Visit& visit) const {
    size_t at = 0;
    for (const Bundle& b : bundles) {
      visit(at, b.segments.size());
      at += b.segments.size();
    }
    if (!bundles.empty()) return;
    for (size_t first = 0; first < segments.size(); first += kArray)
      visit(first, std::min(kArray, segments.size() - first));
  }
};

struct Comparison {
  std::string name;
  uint64_t segments, blocked, differing;
  std::vector<Timing> embree, vcd;
};

class Bench {
 public:
  Bench(const World& world, const std::vector<Object>& objects, int repetitions)
      : world_(world), scene_(scene_of(world, objects)), repetitions_(repetitions) {
    for (const WorldInstance& instance : world.instances)
      hierarchies_.push_back(world.objects[instance.object].tracer.scene());
  }

  // The way for what arrays leave open that is the fastest on other segments than those that are reported.
  EmbreeQuery fastest_fallback(const Rays& rays) const {
    const std::vector<EmbreeQuery> ways = all_packets(false);
    std::vector<Variant> variants;
    for (const EmbreeQuery& way : ways) variants.push_back(arrays(rays, way));
    const std::vector<Timing> timings = time_interleaved(variants, 3);
    return ways[static_cast<size_t>(&fastest(timings) - timings.data())];
  }

  Comparison compare(const std::string& name, const Rays& rays, EmbreeQuery fallback) const {
    Comparison result{name, rays.segments.size(), 0, 0, {}, {}};
    rays.in_parts([&](size_t first, size_t count) {
      uint8_t truth[kArray];
      uint64_t blocked[kArray / 64];
      occluded(world_.shadow_casters(), {1}, std::span(rays.segments).subspan(first, count), truth);
      scene_.occluded(std::span(rays.segments).subspan(first, count), blocked, EmbreeInstances{hierarchies_, fallback},
                      query(rays, first, count));
      for (size_t i = 0; i < count; ++i) {
        result.blocked += truth[i];
        result.differing += truth[i] != (blocked[i / 64] >> (i % 64) & 1);
      }
    });
    std::vector<Variant> variants;
    for (const EmbreeQuery& way : world_.ways_to_trace())
      variants.push_back({name_of(way), [&, way] {
                            uint8_t blocked[kArray];
                            rays.in_parts([&](size_t first, size_t count) {
                              occluded(world_.shadow_casters(), way, std::span(rays.segments).subspan(first, count),
                                       blocked);
                            });
                          }});
    const size_t first_vcd = variants.size();
    // What bounds the others: look-ups for nothing, and of each segment all that is left at once.
    std::vector<Segment> left_open;
    for (size_t i = 0; i < rays.segments.size(); ++i)
      if (scene_.classify(rays.segments[i], query(rays, i, 1)) == Visibility::unclassified)
        left_open.push_back(rays.segments[i]);
    variants.push_back({"what look-ups leave alone, rtcOccluded16", [&] {
                          uint8_t blocked[kArray];
                          for (size_t first = 0; first < left_open.size(); first += kArray)
                            occluded(world_.shadow_casters(), {16},
                                     std::span(left_open).subspan(first, std::min(kArray, left_open.size() - first)),
                                     blocked);
                        }});
    variants.push_back({"look-ups of single segments", [&] {
                          uint64_t sum = 0;
                          for (size_t i = 0; i < rays.segments.size(); ++i)
                            sum += static_cast<uint64_t>(scene_.classify(rays.segments[i], query(rays, i, 1)));
                          sink_ = sum;
                        }});
    if (!rays.bundles.empty())
      variants.push_back({"look-ups of bundles", [&] {
                            uint64_t blocked[kMaxBundle / 64], open[kMaxBundle / 64];
                            for (const Bundle& b : rays.bundles)
                              scene_.classify(quad_of(world_, b), blocked, open, query_of(b));
                          }});
    variants.push_back({"single calls, then rtcOccluded1", [&] {
                          uint64_t blocked = 0;
                          const EmbreeInstances instances{hierarchies_, {1}};
                          for (size_t i = 0; i < rays.segments.size(); ++i) {
                            RTCRay ray = to_ray(rays.segments[i]);
                            occluded1(scene_, instances, &ray, query(rays, i, 1));
                            blocked += ray.tfar < 0;
                          }
                          sink_ = blocked;
                        }});
    variants.push_back(arrays(rays, fallback));
    if (!rays.bundles.empty())
      variants.push_back(
          {"bundles, then " + name_of(fallback), [&, fallback] {
             uint64_t blocked[kMaxBundle / 64];
             for (const Bundle& b : rays.bundles)
               scene_.occluded(quad_of(world_, b), blocked, EmbreeInstances{hierarchies_, fallback}, query_of(b));
           }});
    if (scene_.has_hierarchies()) {
      variants.push_back({"hierarchies, single calls", [&] {
                            uint64_t blocked = 0;
                            for (size_t i = 0; i < rays.segments.size(); ++i)
                              blocked += scene_.occluded(rays.segments[i], query(rays, i, 1));
                            sink_ = blocked;
                          }});
      variants.push_back({"hierarchies, arrays", [&] {
                            uint64_t blocked[kArray / 64];
                            rays.in_parts([&](size_t first, size_t count) {
                              scene_.occluded(std::span(rays.segments).subspan(first, count), blocked,
                                              query(rays, first, count));
                            });
                          }});
      if (!rays.bundles.empty())
        variants.push_back({"hierarchies, bundles", [&] {
                              uint64_t blocked[kMaxBundle / 64];
                              for (const Bundle& b : rays.bundles)
                                scene_.occluded(quad_of(world_, b), blocked, query_of(b));
                            }});
    }
    const std::vector<Timing> timings = time_interleaved(variants, repetitions_);
    const auto at = timings.begin() + static_cast<std::ptrdiff_t>(first_vcd);
    result.embree.assign(timings.begin(), at);
    result.vcd.assign(at, timings.end());
    return result;
  }

 private:
  static SceneQuery query(const Rays& rays, size_t first, size_t count) {
    return {0xFFFFFFFF, std::span(rays.origins).subspan(first, count)};
  }

  Variant arrays(const Rays& rays, EmbreeQuery fallback) const {
    return {"arrays, then " + name_of(fallback), [this, &rays, fallback] {
              uint64_t blocked[kArray / 64];
              rays.in_parts([&](size_t first, size_t count) {
                scene_.occluded(std::span(rays.segments).subspan(first, count), blocked,
                                EmbreeInstances{hierarchies_, fallback}, query(rays, first, count));
              });
            }};
  }

  const World& world_;
  Scene scene_;
  std::vector<RTCScene> hierarchies_;
  int repetitions_;
  mutable volatile uint64_t sink_ = 0;  // keeps the answers from being optimised away
};

void print(const Comparison& c) {
  std::printf("%s: %llu segments, %.2f %% of them blocked; %llu answers differ from Embree's\n", c.name.c_str(),
              static_cast<unsigned long long>(c.segments),
              100 * static_cast<double>(c.blocked) / static_cast<double>(c.segments),
              static_cast<unsigned long long>(c.differing));
  for (const auto* group : {&c.embree, &c.vcd}) print_timings(*group, fastest(c.embree), c.segments);
}

Recording some_bundles(const World& world, size_t points, uint64_t seed) {
  RenderSettings settings;
  settings.pixel_samples = 1, settings.light_samples = 128, settings.seed = seed;
  settings.width = 96, settings.height = 64;
  Recording all = record(world, settings), some;
  for (size_t i = 0; i < all.size(); ++i)
    if (i * points / all.size() != (i + 1) * points / all.size()) some.append(all[i]);
  return some;
}

Rays of_kind(const World& world, const Recording& bundles, bool ground, bool own) {
  Rays rays{&world, {}, {}, {}};
  for (size_t i = 0; i < bundles.size(); ++i)
    if (bundles[i].surface == kGroundSurface ? ground : own) rays.add(bundles[i]);
  return rays;
}

}  // namespace

Result<World> world_of(const InstancesOptions& options) {
  auto request = parse_scene_request(options.scene, {});
  if (!request) return request.error();
  request->options.files = {options.ingest, options.sidecars};
  return load_world(request->source, request->options, options.quiet);
}

int run_instances(const InstancesOptions& options) {
  const auto fail = [](const Error& error) { return print_error(error.message), exit_code(error.code); };
  const auto world = world_of(options);
  if (!world) return fail(world.error());
  if (world->single())
    return fail({ErrorCode::usage, options.scene + ": one object in one place; see vc-bench segments"});
  const auto sidecars = open_sidecars(*world, options.sidecars);
  if (!sidecars) return fail(sidecars.error());

  const Bench bench(*world, sidecars->objects, options.repetitions);
  const Recording bundles = some_bundles(*world, options.points, 7),
                  trial = some_bundles(*world, options.points / 8 + 1, 1007);
  std::vector<Comparison> comparisons;
  for (const bool shuffled : {false, true})
    for (const auto& [name, ground, own] :
         {std::tuple("from the ground", true, false), std::tuple("from instances", false, true),
          std::tuple("ground and instances together", true, true)}) {
      Rays rays = of_kind(*world, bundles, ground, own), other = of_kind(*world, trial, ground, own);
      if (rays.segments.empty()) continue;
      if (shuffled) rays.shuffle(1), other.shuffle(2);
      comparisons.push_back(
          bench.compare(std::string(name) + (shuffled ? ", shuffled" : ""), rays, bench.fastest_fallback(other)));
    }
  if (options.format == OutputFormat::json) {
    Json json{{"tool", "vc-bench"},
              {"version", VCD_VERSION},
              {"machine", machine_description()},
              {"repetitions", options.repetitions},
              {"scene", options.scene},
              {"instances", world->instances.size()},
              {"sidecars", options.sidecars},
              {"kinds", Json::array()}};
    for (const Comparison& c : comparisons)
      json["kinds"].push_back({{"name", c.name},
                               {"segments", c.segments},
                               {"blocked", c.blocked},
                               {"differing", c.differing},
                               {"embree", describe(c.embree, fastest(c.embree), c.segments)},
                               {"vcd", describe(c.vcd, fastest(c.embree), c.segments)}});
    print_json(json);
    return kExitOk;
  }
  std::printf("%s, one thread, %d interleaved repetitions: medians (minimum to maximum)\n",
              machine_description().c_str(), options.repetitions);
  for (const Comparison& c : comparisons) print(c);
  return kExitOk;
}

}  // namespace vcd::bench
