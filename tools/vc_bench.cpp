// vc-bench: what a sidecar gains, and what the baker and the look-up cost beside bare Embree.
#include <cstdio>

#include <embree3/rtcore.h>

#include <vcd/baker/audit.h>
#include <vcd/baker/prepare.h>
#include <vcd/baker/tracer.h>
#include <vcd/runtime/embree.h>
#include <vcd/runtime/sidecar.h>

#include "bench/bake_rate.h"
#include "bench/shadow_rays.h"
#include "bench/timing.h"
#include "common/describe.h"
#include "common/meshes.h"
#include "common/program.h"

namespace {

using namespace vcd;

struct Options {
  CommonOptions common;
  std::string mesh, sidecar;
  size_t object = 0;
  size_t points = 4000;
  int repetitions = 7;
  BakeRateOptions bake_rate;
};

struct Loaded {
  PreparedMesh mesh;
  Tracer tracer;
};

// The mesh with that hash, or the first.
Result<Loaded> load(const std::string& path, const SidecarContents* contents, const std::array<uint8_t, 16>* hash) {
  auto meshes = load_meshes(path, contents);
  if (!meshes) return meshes.error();
  for (PreparedMesh& mesh : *meshes) {
    if (hash && mesh.geometry_hash != *hash) continue;
    auto tracer = Tracer::build(mesh.positions, mesh.triangles, TraceMode::fast);
    if (!tracer) return tracer.error();
    return Loaded{std::move(mesh), std::move(*tracer)};
  }
  return Error{ErrorCode::stale, path + ": none of its meshes has the sidecar's geometry hash"};
}

RTCRay to_ray(const Segment& s) {
  RTCRay ray{};
  ray.org_x = s.origin[0], ray.org_y = s.origin[1], ray.org_z = s.origin[2];
  ray.dir_x = s.direction[0], ray.dir_y = s.direction[1], ray.dir_z = s.direction[2];
  ray.tnear = s.t_min, ray.tfar = s.t_max, ray.mask = 0xFFFFFFFF;
  return ray;
}

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

void print_timing(const Timing& t, uint64_t segments) {
  const double scale = 1e9 / static_cast<double>(segments);
  std::printf("  %-40s %7.1f ns a segment (%.1f to %.1f)\n", t.name.c_str(), t.median * scale, t.minimum * scale,
              t.maximum * scale);
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

int run_segments(const Options& options) {
  const auto sidecar = Sidecar::open(options.sidecar);
  if (!sidecar) return print_error(sidecar.error().message), exit_code(sidecar.error().code);
  if (options.object >= sidecar->object_count())
    return print_error(options.sidecar + ": it has no such object"), exit_code(ErrorCode::usage);
  const Object object = sidecar->object(options.object);
  const auto loaded = load(options.mesh, &sidecar->contents(), &object.record().geometry_hash);
  if (!loaded) return print_error(loaded.error().message), exit_code(loaded.error().code);

  const RTCScene scene = loaded->tracer.scene();
  const auto shadow = compare(object, scene, shadow_rays(loaded->mesh, options.points, 128, 7), options.repetitions);
  const auto bundles = compare(object, scene, piercing_bundles(loaded->mesh, options.points / 32 + 1, 128, 7), options.repetitions);
  const auto chords = compare(object, scene, audit_segments(loaded->mesh, AuditKind::chords, 7, options.points * 128),
                              options.repetitions);
  if (options.common.format == OutputFormat::json) {
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

int run_bake_rate(const Options& options) {
  const auto loaded = load(options.mesh, nullptr, nullptr);
  if (!loaded) return print_error(loaded.error().message), exit_code(loaded.error().code);
  const auto rate = measure_bake_rate(loaded->mesh, options.bake_rate, options.repetitions);
  if (!rate) return print_error(rate.error().message), exit_code(rate.error().code);
  const double rays = static_cast<double>(rate->rays);
  if (options.common.format == OutputFormat::json) {
    print_json({{"tool", "vc-bench"}, {"version", VCD_VERSION}, {"machine", machine_description()}, {"rays", rate->rays},
                {"classification_ns", 1e9 * rate->classification.median / rays},
                {"rtcOccluded16_ns", 1e9 * rate->bare16.median / rays}, {"ratio", rate->bare16.median / rate->classification.median}});
    return kExitOk;
  }
  std::printf("%s, one thread, %d interleaved repetitions: medians (minimum to maximum)\n%llu rays of a bake\n",
              machine_description().c_str(), options.repetitions, static_cast<unsigned long long>(rate->rays));
  print_timing(rate->classification, rate->rays);
  print_timing(rate->bare16, rate->rays);
  std::printf("  the bake traces at %.2f times the rate of bare rtcOccluded16 on the same rays\n",
              rate->bare16.median / rate->classification.median);
  return kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Measures sidecars against bare Embree on this machine: variants interleaved, medians, ratios."};
  app.require_subcommand(1);
  app.fallthrough();  // the options of all may come after the subcommand too
  add_common_options(app, options.common);
  app.add_option("--repetitions", options.repetitions, "How often each variant runs (default: 7)")->check(CLI::Range(1, 1000));

  CLI::App* segments = app.add_subcommand("segments", "Segments with and without a sidecar: answers, shares, times");
  segments->add_option("sidecar", options.sidecar)->required()->type_name("SIDECAR");
  segments->add_option("mesh", options.mesh, "The mesh file that it was baked from")->required()->type_name("MESH");
  segments->add_option("--object", options.object, "Index of the object in the sidecar (default: 0)");
  segments->add_option("--points", options.points, "Ground points, 128 shadow rays each (default: 4000)")->check(CLI::Range(1, 1000000));

  CLI::App* bake = app.add_subcommand("bake-rate", "How fast a bake traces, against bare rtcOccluded16 on its rays");
  bake->add_option("mesh", options.mesh)->required()->type_name("MESH");
  bake->add_option("-d,--depth", options.bake_rate.depth, "Depth of the bake (default: 5)")->check(CLI::Range(1, 8));
  bake->add_option("-s,--samples", options.bake_rate.samples, "Rays a cell (default: 256)")->check(CLI::IsMember({16, 81, 256}));
  bake->add_option("--cells", options.bake_rate.top_cells, "Random cells of level 3 to bake (default: 200)");
  return run_program(app, argc, argv, [&] { return segments->parsed() ? run_segments(options) : run_bake_rate(options); });
}
