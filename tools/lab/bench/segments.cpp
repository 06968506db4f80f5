#include "segments.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>

#include <embree3/rtcore.h>

#include <vcd/baker/audit.h>
#include <vcd/baker/referee.h>
#include <vcd/runtime/embree.h>
#include <vcd/runtime/sidecar.h>

#include "common/describe.h"
#include "common/meshes.h"
#include "machine.h"
#include "render/packets.h"
#include "shadow_rays.h"
#include "timing.h"
#include "traced_mesh.h"

namespace vcd::bench {

using namespace baker;
using namespace tools;
using namespace render;
namespace {

constexpr size_t kArray = 1024;  // segments of one call, as a renderer with a bundle or a queue would have

// One set of segments, each way through it timed: Embree's; look-ups alone; look-ups with Embree for what they leave.
struct Comparison {
  uint64_t segments = 0, answered = 0, blocked_bvh = 0, blocked_both = 0, differ = 0;
  // In exact arithmetic, of the first `judged` segments: wrong answers of Embree's, and of the hierarchy's.
  uint64_t judged = 0, wrong_embree = 0, wrong_alone = 0;
  std::vector<Timing> embree, look_ups, wholes, alone;
};

// The same segments as structure of arrays.
class Columns {
 public:
  explicit Columns(std::span<const Segment> segments) : count_(segments.size()), values_(8 * count_) {
    for (size_t i = 0; i < count_; ++i)
      for (size_t a = 0; a < 3; ++a) {
        values_[a * count_ + i] = segments[i].origin[a], values_[(4 + a) * count_ + i] = segments[i].direction[a];
        values_[3 * count_ + i] = segments[i].t_min, values_[7 * count_ + i] = segments[i].t_max;
      }
  }
  SegmentArrays part(size_t first, size_t count) const {
    const auto at = [&](size_t k) { return values_.data() + k * count_ + first; };
    return {{at(0), at(1), at(2)}, at(3), {at(4), at(5), at(6)}, at(7), count};
  }

 private:
  size_t count_;
  std::vector<float> values_;
};

// One object, opened once for each kernel; those of `kernels` live as long as this. With a hierarchy also for the ways
// to be asked without a fallback.
struct Opened {
  std::vector<std::string> names;
  std::vector<Sidecar> sidecars;
  struct Alone {
    std::string name;
    Sidecar sidecar;
  };
  std::vector<Alone> alone;
  size_t object;
};

class Bench {
 public:
  Bench(const Opened& opened, const PreparedMesh& mesh, RTCScene scene, int repetitions)
      : opened_(opened), scene_(scene), referee_(mesh), repetitions_(repetitions) {}

  // fallback: the packets for what look-ups of arrays leave open; chosen on other segments than these.
  // bundles: the same segments in the same order, or nothing.
  Comparison compare(const std::vector<Segment>& segments, EmbreeQuery fallback,
                     std::span<const QuadBundle> bundles = {}) const;

  // Embree's fastest way through these segments.
  EmbreeQuery fastest_way(const std::vector<Segment>& segments) const {
    std::vector<Variant> variants;
    for (const EmbreeQuery& way : all_packets(false)) variants.push_back(traced(way, segments));
    const std::vector<Timing> timings = time_interleaved(variants, repetitions_);
    return all_packets(false)[static_cast<size_t>(&fastest(timings) - timings.data())];
  }

 private:
  void judge(const std::vector<Segment>& segments, Comparison& result) const;
  Object object(size_t kernel) const { return opened_.sidecars[kernel].object(opened_.object); }

  Variant traced(EmbreeQuery way, const std::vector<Segment>& segments) const {
    return {name_of(way), [this, way, &segments] {
              uint8_t blocked[kArray];
              in_parts(segments, [&](std::span<const Segment> part, size_t) { occluded(scene_, way, part, blocked); });
            }};
  }

  template <class Visit>
  static void in_parts(std::span<const Segment> segments, const Visit& visit) {
    for (size_t first = 0; first < segments.size(); first += kArray)
      visit(segments.subspan(first, std::min(kArray, segments.size() - first)), first);
  }

  const Opened& opened_;
  RTCScene scene_;
  Referee referee_;
  int repetitions_;
};

void Bench::judge(const std::vector<Segment>& segments, Comparison& result) const {
  const auto some = std::span(segments).first(std::min<size_t>(segments.size(), 100'000));
  std::vector<uint8_t> truth(some.size());
  referee_.occluded(some, truth);
  result.judged = some.size();
  const Object object = opened_.alone.front().sidecar.object(opened_.object);
  for (size_t i = 0; i < some.size(); ++i) {
    result.wrong_embree += occluded_by_bvh(scene_, some[i]) != (truth[i] != 0);
    result.wrong_alone += object.occluded(some[i]) != (truth[i] != 0);
  }
}

Comparison Bench::compare(const std::vector<Segment>& segments, EmbreeQuery fallback,
                          std::span<const QuadBundle> bundles) const {
  Comparison result;
  result.segments = segments.size();
  const Object single = object(0);
  for (const Segment& s : segments) {
    const Visibility answer = single.classify(s);
    const bool by_bvh = occluded_by_bvh(scene_, s);
    const bool combined = single.occluded(s, [&] { return by_bvh; });
    result.answered += answer != Visibility::unclassified;
    result.blocked_bvh += by_bvh;
    result.blocked_both += combined;
    result.differ += by_bvh != combined;
  }

  if (!opened_.alone.empty()) judge(segments, result);
  std::vector<Variant> variants;
  for (const EmbreeQuery& way : all_packets(false)) variants.push_back(traced(way, segments));
  const size_t first_look_up = variants.size();
  volatile uint64_t sink = 0;  // keeps the answers from being optimised away
  variants.push_back({"single calls", [&] {
                        uint64_t sum = 0;
                        for (const Segment& s : segments) sum += static_cast<uint64_t>(single.classify(s));
                        sink = sum;
                      }});
  for (size_t k = 0; k < opened_.names.size(); ++k)
    variants.push_back({opened_.names[k] + ", array of structures", [&, k] {
                          Visibility answers[kArray];
                          in_parts(segments,
                                   [&](std::span<const Segment> part, size_t) { object(k).classify(part, answers); });
                        }});
  const Columns columns(segments);
  for (size_t k = 0; k < opened_.names.size(); ++k)
    variants.push_back({opened_.names[k] + ", structure of arrays", [&, k] {
                          Visibility answers[kArray];
                          in_parts(segments, [&](std::span<const Segment> part, size_t first) {
                            object(k).classify(columns.part(first, part.size()), answers);
                          });
                        }});
  for (size_t k = 0; k < opened_.names.size() && !bundles.empty(); ++k)
    variants.push_back({opened_.names[k] + ", bundles", [&, k] {
                          uint64_t blocked[kLightSamples / 64], open[kLightSamples / 64];
                          for (const QuadBundle& bundle : bundles) object(k).classify(bundle, blocked, open);
                        }});
  const size_t first_whole = variants.size();
  // What bounds the others: look-ups for nothing.
  std::vector<Segment> left_open;
  for (const Segment& s : segments)
    if (single.classify(s) == Visibility::unclassified) left_open.push_back(s);
  variants.push_back(
      {"what look-ups leave alone, " + name_of(fallback), [&] {
         uint8_t blocked[kArray];
         in_parts(left_open, [&](std::span<const Segment> part, size_t) { occluded(scene_, fallback, part, blocked); });
       }});
  variants.push_back({"single calls, then rtcOccluded1", [&] {
                        RTCIntersectContext context;
                        rtcInitIntersectContext(&context);
                        uint64_t blocked = 0;
                        for (const Segment& s : segments) {
                          RTCRay ray = to_ray(s);
                          occluded1(single, scene_, &context, &ray);
                          blocked += ray.tfar < 0;
                        }
                        sink = blocked;
                      }});
  variants.push_back({opened_.names[0] + " arrays, then " + name_of(fallback), [&] {
                        Visibility answers[kArray];
                        std::array<Segment, kArray> left;
                        uint8_t blocked[kArray];
                        in_parts(segments, [&](std::span<const Segment> part, size_t) {
                          single.classify(part, answers);
                          size_t count = 0;
                          for (size_t i = 0; i < part.size(); ++i) {
                            left[count] = part[i];
                            count += answers[i] == Visibility::unclassified;
                          }
                          occluded(scene_, fallback, std::span(left).first(count), blocked);
                        });
                      }});
  // After each bundle, and from a queue of what several leave.
  for (const size_t queue : {kLightSamples, kArray}) {
    if (bundles.empty()) continue;
    variants.push_back(
        {opened_.names[0] + (queue == kArray ? " bundles, queue, then " : " bundles, then ") + name_of(fallback),
         [&, queue] {
           uint64_t blocked[kLightSamples / 64], open[kLightSamples / 64];
           std::array<Segment, kArray + kLightSamples> left;
           uint8_t traced[kArray + kLightSamples];
           size_t count = 0;
           for (size_t b = 0; b < bundles.size(); ++b) {
             single.classify(bundles[b], blocked, open);
             for (size_t w = 0; w < std::size(open); ++w)
               for (uint64_t rest = open[w]; rest; rest &= rest - 1)
                 left[count++] = segments[b * kLightSamples + 64 * w + static_cast<size_t>(std::countr_zero(rest))];
             if (count < queue && queue == kArray && b + 1 < bundles.size()) continue;
             occluded(scene_, fallback, std::span(left).first(count), traced);
             count = 0;
           }
         }});
  }
  const size_t first_alone = variants.size();
  for (const Opened::Alone& way : opened_.alone) {
    const Object object = way.sidecar.object(opened_.object);
    variants.push_back({way.name + ", single calls", [&, object] {
                          uint64_t sum = 0;
                          for (const Segment& s : segments) sum += object.occluded(s);
                          sink = sum;
                        }});
    variants.push_back({way.name + ", arrays", [&, object] {
                          uint64_t blocked[kArray / 64];
                          in_parts(segments,
                                   [&](std::span<const Segment> array, size_t) { object.occluded(array, blocked); });
                        }});
    if (!bundles.empty())
      variants.push_back({way.name + ", bundles", [&, object] {
                            uint64_t blocked[kLightSamples / 64];
                            for (const QuadBundle& bundle : bundles) object.occluded(bundle, blocked);
                          }});
  }
  const std::vector<Timing> timings = time_interleaved(variants, repetitions_);
  const auto part = [&](size_t from, size_t to) {
    return std::vector<Timing>(timings.begin() + static_cast<std::ptrdiff_t>(from),
                               timings.begin() + static_cast<std::ptrdiff_t>(to));
  };
  result.embree = part(0, first_look_up);
  result.look_ups = part(first_look_up, first_whole);
  result.wholes = part(first_whole, first_alone);
  result.alone = part(first_alone, timings.size());
  return result;
}

Json describe(const Comparison& c) {
  const Timing& best = fastest(c.embree);
  return {{"segments", c.segments},
          {"answered", c.answered},
          {"blocked_by_bvh", c.blocked_bvh},
          {"blocked_with_sidecar", c.blocked_both},
          {"differ", c.differ},
          {"judged", c.judged},
          {"wrong_embree", c.wrong_embree},
          {"wrong_hierarchy", c.wrong_alone},
          {"best_embree", best.name},
          {"embree", describe(c.embree, best, c.segments)},
          {"look_ups", describe(c.look_ups, best, c.segments)},
          {"with_sidecar", describe(c.wholes, best, c.segments)},
          {"without_fallback", describe(c.alone, best, c.segments)}};
}

void print(const char* what, const Comparison& c) {
  const auto percent = [&](uint64_t n) { return 100 * static_cast<double>(n) / static_cast<double>(c.segments); };
  std::printf("%s: %llu segments\n", what, static_cast<unsigned long long>(c.segments));
  std::printf(
      "  blocked by the BVH %.4f %%, with the sidecar %.4f %%; %.4f %% of all answers differ; %.1f %% need no BVH\n",
      percent(c.blocked_bvh), percent(c.blocked_both), percent(c.differ), percent(c.answered));
  if (c.judged > 0)
    std::printf("  in exact arithmetic, of %llu: Embree wrong %llu times, the hierarchy %llu times\n",
                static_cast<unsigned long long>(c.judged), static_cast<unsigned long long>(c.wrong_embree),
                static_cast<unsigned long long>(c.wrong_alone));
  for (const auto* group : {&c.embree, &c.look_ups, &c.wholes, &c.alone})
    print_timings(*group, fastest(c.embree), c.segments);
}

}  // namespace

int run_segments(const SegmentsOptions& options) {
  Opened opened{kernels(), {}, {}, options.object};
  for (const std::string& kernel : opened.names) {
    OpenOptions open_options;
    open_options.kernel = kernel;
    auto sidecar = Sidecar::open(options.sidecar, open_options);
    if (!sidecar) return print_error(sidecar.error().message), exit_code(sidecar.error().code);
    opened.sidecars.push_back(std::move(*sidecar));
  }
  const Sidecar& sidecar = opened.sidecars[0];
  if (options.object >= sidecar.object_count())
    return print_error(options.sidecar + ": it has no such object"), exit_code(ErrorCode::usage);
  if (sidecar.object(options.object).has_hierarchy())
    for (const auto& [name, look_up] :
         {std::pair("hierarchy", LookUpFirst::never), std::pair("look-ups, hierarchy", LookUpFirst::always)}) {
      OpenOptions open_options;
      open_options.look_up = look_up;
      auto alone = Sidecar::open(options.sidecar, open_options);
      if (!alone) return print_error(alone.error().message), exit_code(alone.error().code);
      opened.alone.push_back({name, std::move(*alone)});
    }
  const IngestOptions ingest = ingest_options_of(sidecar.contents(), options.mesh.ingest);
  const auto loaded = TracedMesh::load({options.mesh.path, ingest, options.mesh.quiet},
                                       &sidecar.object(options.object).record().geometry_hash);
  if (!loaded) return print_error(loaded.error().message), exit_code(loaded.error().code);

  const PreparedMesh& mesh = loaded->mesh;
  const Bench bench(opened, mesh, loaded->tracer.scene(), options.repetitions);
  const auto measured = [&](const auto& segments_of) {
    return bench.compare(segments_of(options.points, 7), bench.fastest_way(segments_of(options.points / 8 + 1, 1007)));
  };
  const LightBundles rays = shadow_rays(mesh, options.points, 7);
  const auto shadow = bench.compare(
      rays.segments, bench.fastest_way(shadow_rays(mesh, options.points / 8 + 1, 1007).segments), rays.bundles);
  const auto bundles =
      measured([&](size_t points, uint64_t seed) { return piercing_bundles(mesh, points / 32 + 1, 128, seed); });
  const auto chords = measured(
      [&](size_t points, uint64_t seed) { return audit_segments(mesh, AuditKind::chords, seed, points * 128); });
  if (options.format == OutputFormat::json) {
    print_json({{"tool", "vc-bench"},
                {"version", VCD_VERSION},
                {"machine", machine_description()},
                {"repetitions", options.repetitions},
                {"sidecar", options.sidecar},
                {"mesh", options.mesh.path},
                {"shadow_rays", describe(shadow)},
                {"bundles", describe(bundles)},
                {"chords", describe(chords)}});
    return kExitOk;
  }
  std::printf("%s, one thread, %d interleaved repetitions: medians (minimum to maximum)\n",
              machine_description().c_str(), options.repetitions);
  print("shadow rays (ground points to 128 samples of a square light)", shadow);
  print("bundles of 128 that pierce the box", bundles);
  print("scattered lines (isotropic, in random order)", chords);
  return kExitOk;
}

}  // namespace vcd::bench
