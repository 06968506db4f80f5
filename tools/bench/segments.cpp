#include "segments.h"

#include <cstdio>

#include <embree3/rtcore.h>

#include <vcd/baker/audit.h>
#include <vcd/runtime/embree.h>
#include <vcd/runtime/sidecar.h>

#include "common/describe.h"
#include "machine.h"
#include "render/packets.h"
#include "shadow_rays.h"
#include "timing.h"
#include "traced_mesh.h"

namespace vcd {
namespace {

bool occluded_by_bvh(RTCScene scene, const Segment& segment) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = to_ray(segment);
  rtcOccluded1(scene, &context, &ray);
  return ray.tfar < 0;
}

struct Comparison {
  uint64_t segments = 0, answered = 0, blocked_bvh = 0, blocked_both = 0, wrong = 0;
  Timing bvh, lookup, both;
};

// One set of segments: rtcOccluded1 for all; the look-up for all; the look-up with rtcOccluded1 for the rest.
Comparison compare(const Object& object, RTCScene scene, const std::vector<Segment>& segments, int repetitions) {
  Comparison result;
  result.segments = segments.size();
  for (const Segment& s : segments) {
    const Visibility answer = object.classify(s);
    const bool traced = occluded_by_bvh(scene, s);
    const bool combined = object.occluded(s, [&] { return traced; });
    result.answered += answer != Visibility::unclassified;
    result.blocked_bvh += traced;
    result.blocked_both += combined;
    result.wrong += traced != combined;
  }
  volatile uint64_t sink = 0;  // keeps the answers from being optimised away
  const std::vector<Variant> variants = {
      {"rtcOccluded1",
       [&] {
         uint64_t blocked = 0;
         for (const Segment& s : segments) blocked += occluded_by_bvh(scene, s);
         sink = blocked;
       }},
      {"look-up",
       [&] {
         uint64_t sum = 0;
         for (const Segment& s : segments) sum += static_cast<uint64_t>(object.classify(s));
         sink = sum;
       }},
      {"look-up, then rtcOccluded1 for the rest",
       [&] {
         RTCIntersectContext context;
         rtcInitIntersectContext(&context);
         uint64_t blocked = 0;
         for (const Segment& s : segments) {
           RTCRay ray = to_ray(s);
           occluded1(object, scene, &context, &ray);
           blocked += ray.tfar < 0;
         }
         sink = blocked;
       }},
  };
  const std::vector<Timing> timings = time_interleaved(variants, repetitions);
  result.bvh = timings[0], result.lookup = timings[1], result.both = timings[2];
  return result;
}

Json describe(const Timing& t, uint64_t segments) {
  const double scale = 1e9 / static_cast<double>(segments);
  return {{"median_ns", t.median * scale}, {"minimum_ns", t.minimum * scale}, {"maximum_ns", t.maximum * scale}};
}

Json describe(const Comparison& c) {
  return {{"segments", c.segments}, {"answered", c.answered}, {"blocked_by_bvh", c.blocked_bvh},
          {"blocked_with_sidecar", c.blocked_both}, {"wrong", c.wrong}, {"rtcOccluded1", describe(c.bvh, c.segments)},
          {"lookup", describe(c.lookup, c.segments)}, {"with_sidecar", describe(c.both, c.segments)},
          {"lookup_ratio", c.bvh.median / c.lookup.median}, {"speed_up", c.bvh.median / c.both.median}};
}

void print(const char* what, const Comparison& c) {
  const auto percent = [&](uint64_t n) { return 100 * static_cast<double>(n) / static_cast<double>(c.segments); };
  std::printf("%s: %llu segments\n", what, static_cast<unsigned long long>(c.segments));
  std::printf("  blocked by the BVH %.4f %%, with the sidecar %.4f %%; %.4f %% of all answers differ\n",
              percent(c.blocked_bvh), percent(c.blocked_both), percent(c.wrong));
  std::printf("  %.1f %% of the segments needed no BVH\n", percent(c.answered));
  for (const Timing& t : {c.bvh, c.lookup, c.both}) print_timing(t, c.segments);
  std::printf("  a look-up is %.1f times faster than rtcOccluded1; the sidecar makes the whole %.2f times faster\n",
              c.bvh.median / c.lookup.median, c.bvh.median / c.both.median);
}

}  // namespace

int run_segments(const SegmentsOptions& options) {
  const auto sidecar = Sidecar::open(options.sidecar);
  if (!sidecar) return print_error(sidecar.error().message), exit_code(sidecar.error().code);
  if (options.object >= sidecar->object_count())
    return print_error(options.sidecar + ": it has no such object"), exit_code(ErrorCode::usage);
  const Object object = sidecar->object(options.object);
  const auto loaded = TracedMesh::load(options.mesh, &sidecar->contents(), &object.record().geometry_hash);
  if (!loaded) return print_error(loaded.error().message), exit_code(loaded.error().code);

  const RTCScene scene = loaded->tracer.scene();
  const auto shadow = compare(object, scene, shadow_rays(loaded->mesh, options.points, 128, 7), options.repetitions);
  const auto bundles = compare(object, scene, piercing_bundles(loaded->mesh, options.points / 32 + 1, 128, 7), options.repetitions);
  const auto chords = compare(object, scene, audit_segments(loaded->mesh, AuditKind::chords, 7, options.points * 128),
                              options.repetitions);
  if (options.format == OutputFormat::json) {
    print_json({{"tool", "vc-bench"}, {"version", VCD_VERSION}, {"machine", machine_description()},
                {"repetitions", options.repetitions}, {"sidecar", options.sidecar}, {"mesh", options.mesh},
                {"shadow_rays", describe(shadow)}, {"bundles", describe(bundles)}, {"chords", describe(chords)}});
    return kExitOk;
  }
  std::printf("%s, one thread, %d interleaved repetitions: medians (minimum to maximum)\n",
              machine_description().c_str(), options.repetitions);
  print("shadow rays (ground points to 128 samples of a square light)", shadow);
  print("bundles of 128 that pierce the box", bundles);
  print("scattered lines (isotropic, in random order)", chords);
  return kExitOk;
}

}  // namespace vcd
