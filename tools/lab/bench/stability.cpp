#include "stability.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <vcd/baker/bake.h>
#include <vcd/baker/referee.h>
#include <vcd/baker/tracer.h>
#include <vcd/format/demand.h>
#include <vcd/format/layout.h>
#include <vcd/runtime/sidecar.h>
#include <vcd/writer/atomic_file.h>

#include "common/describe.h"
#include "machine.h"

namespace vcd::bench {

using namespace baker;
using namespace tools;

struct StabilityMesh {
  PreparedMesh mesh;
  Referee referee;
  Tracer fast, robust;
  std::vector<AlignedBytes> files;
  std::vector<Sidecar> sidecars;  // proven, hybrid, sampled; asked without look-ups; and hybrid by proofs alone

  std::string no_hierarchy;  // why they have none; empty: they have

  Object object(size_t sidecar) const { return sidecars[sidecar].object(0); }
};

namespace {

constexpr size_t kHybridByProofs = kSidecarMethods;  // of StabilityMesh::sidecars

Segment drawn(const StabilitySweep::Point& point, const PreparedMesh& mesh, Random& random, uint32_t& key) {
  return point.from_self ? point.from_self(mesh, random, key) : point.segment(mesh, random);
}

// Lines through the box are among them, so that there is always a line that can be looked up.
Demand demand_of(const StabilitySweep::Point& point, const PreparedMesh& mesh, uint64_t seed) {
  constexpr size_t kOfThePoint = 4000, kThroughTheBox = 1000;
  Random random(seed);
  std::vector<AskedSegment> asked;
  for (size_t i = 0; i < kOfThePoint + kThroughTheBox; ++i) {
    uint32_t key;
    const Segment segment = i < kOfThePoint ? drawn(point, mesh, random, key) : through_the_box(mesh, random, 2);
    if (usable_in_demand(segment)) asked.push_back({segment, 1});
  }
  std::ranges::sort(asked, comes_before, &AskedSegment::segment);
  const auto twice = std::ranges::unique(
      asked, [](const AskedSegment& a, const AskedSegment& b) { return !comes_before(a.segment, b.segment); });
  asked.erase(twice.begin(), twice.end());
  return {{mesh.geometry_hash, std::move(asked)}};
}

Result<StabilityMesh> make_mesh(SourceMesh&& source, const StabilitySweep::Point& point, const StabilityBakes& bakes,
                                uint64_t seed) {
  auto prepared = prepare(std::move(source));
  if (!prepared) return prepared.error();
  auto fast = Tracer::build(prepared->positions, prepared->triangles, TraceMode::fast);
  auto robust = Tracer::build(prepared->positions, prepared->triangles, TraceMode::robust);
  if (!fast || !robust) return fast ? robust.error() : fast.error();
  Referee referee(*prepared);
  StabilityMesh made{std::move(*prepared), std::move(referee), std::move(*fast), std::move(*robust), {}, {}, {}};
  const Demand demand = bakes.for_segments ? demand_of(point, made.mesh, seed) : Demand{};
  for (Method method : {Method::proven, Method::hybrid, Method::sampled}) {
    BakeOptions options;
    options.method = method, options.depth = bakes.depth, options.audit_lines = kQuickAuditLines;
    if (bakes.for_segments) options.demand = &demand, options.budget_bytes = bakes.budget_bytes;
    options.horizons = method == Method::proven;
    const auto baked = bake(made.mesh, options);
    if (!baked) return baked.error();
    made.no_hierarchy = baked->without_hierarchy;
    SidecarToWrite file;
    file.objects = {baked->to_write()};
    auto bytes = sidecar_bytes(file);
    if (!bytes) return bytes.error();
    made.files.push_back(std::move(*bytes));
  }
  for (size_t i : {0, 1, 2, 0, 1}) {
    OpenOptions options;
    options.proven_only = made.sidecars.size() == kHybridByProofs;
    options.look_up = LookUpFirst::never;
    auto opened = Sidecar::open_buffer({made.files[i].data.get(), made.files[i].size}, options);
    if (!opened) return opened.error();
    made.sidecars.push_back(std::move(*opened));
  }
  return made;
}

// Wrong and resolved answers of horizons. keys: triangles of the mesh.
StabilityCounts ask_horizons(const StabilityMesh& subject, std::span<const Segment> segments,
                             std::span<const uint32_t> keys, std::span<const uint8_t> truth) {
  StabilityCounts counts;
  const std::vector<uint32_t>& became = subject.mesh.source_triangles;
  std::vector<uint32_t> source(subject.mesh.triangles.size());
  for (uint32_t i = 0; i < became.size(); ++i)
    if (became[i] != kNone) source[became[i]] = i;
  for (size_t i = 0; i < segments.size(); ++i) {
    if (subject.object(0).classify_self(segments[i], source[keys[i]]) != Visibility::clear) continue;
    ++counts.resolved, counts.wrong += truth[i];
  }
  return counts;
}

StabilityPoint ask(const StabilityMesh& subject, const StabilitySweep::Point& asked, uint64_t seed) {
  const uint64_t rays = asked.rays;
  StabilityPoint point;
  point.rays = rays;
  point.no_hierarchy = subject.no_hierarchy;
  Random random(seed);
  std::vector<Segment> segments(rays);
  std::vector<uint32_t> keys(rays);
  for (uint64_t i = 0; i < rays; ++i) {
    if (!asked.from_self) keys[i] = static_cast<uint32_t>(i % subject.mesh.triangles.size());
    segments[i] = drawn(asked, subject.mesh, random, keys[i]);
  }
  std::vector<uint8_t> truth(rays);
  subject.referee.occluded(segments, truth);
  point.horizons = ask_horizons(subject, segments, keys, truth);
  for (uint64_t i = 0; i < rays; ++i) {
    const bool blocked = truth[i] != 0;
    point.blocked += blocked;
    const auto is_wrong = [&](Visibility answer) {
      return answer != Visibility::unclassified && (answer == Visibility::blocked) != blocked;
    };
    for (size_t m = 0; m < kLookUpMethods; ++m) {
      const Visibility answer = subject.object(m).classify(segments[i]);
      point.counts[m].resolved += answer != Visibility::unclassified;
      point.counts[m].wrong += is_wrong(answer);
    }
    point.wrong_proven += is_wrong(subject.object(kHybridByProofs).classify(segments[i]));
    if (point.no_hierarchy.empty())
      point.counts[kHierarchyMethod].wrong += subject.object(kHierarchyMethod).occluded(segments[i]) != blocked;
    point.counts[kEmbreeMethod].wrong += subject.fast.occluded(segments[i]) != blocked;
    point.counts[kRobustMethod].wrong += subject.robust.occluded(segments[i]) != blocked;
  }
  if (point.no_hierarchy.empty()) point.counts[kHierarchyMethod].resolved = rays;
  point.counts[kEmbreeMethod].resolved = point.counts[kRobustMethod].resolved = rays;
  return point;
}

SegmentMaker from_boxes_away(double boxes) {
  return [boxes](const PreparedMesh& mesh, Random& random) { return through_the_box(mesh, random, boxes); };
}

}  // namespace

std::vector<StabilitySweep> stability_sweeps(bool quick) {
  const uint64_t rays = quick ? 2000 : 20000;
  const auto powers = [&](int first, int last) {
    std::vector<double> values;
    for (int e = first; e <= last; e += quick ? std::max(1, (last - first) / 3) : std::max(1, (last - first) / 12))
      values.push_back(std::pow(10.0, e));
    return values;
  };
  const auto sphere = [] { return stability_sphere(); };
  std::vector<StabilitySweep> sweeps;
  const auto sweep = [&](const char* id, const char* title, const char* parameter,
                         const char* scale) -> StabilitySweep& {
    sweeps.push_back({id, title, parameter, scale, {}});
    return sweeps.back();
  };

  StabilitySweep& origin = sweep("origin-distance", "The origin far away", "distance of the origin, boxes", "log");
  for (double d : powers(0, 7))
    origin.points.push_back(
        {d, origin.points.empty() ? std::function<SourceMesh()>(sphere) : nullptr, from_boxes_away(d), rays});

  StabilitySweep& far =
      sweep("mesh-distance", "The mesh far from its frame's origin", "distance of the mesh, its own sizes", "log");
  for (double d : powers(0, 7)) {
    const auto x = static_cast<float>(d);
    far.points.push_back({d,
                          [x] {
                            return shifted(stability_sphere(), {2 * x, -x, 0.5f * x});
                          },
                          from_boxes_away(2), rays});
  }
  StabilitySweep& aspect = sweep("aspect", "A flat box", "extent of the box along x and y over that along z", "log");
  for (double d : powers(0, 6)) {
    const auto z = static_cast<float>(1 / d);
    aspect.points.push_back({d, [z] { return scaled(stability_sphere(), {1, 1, z}); }, from_boxes_away(2), rays});
  }
  StabilitySweep& sliver = sweep("slivers", "Needle triangles", "length over width of the triangles", "log");
  for (double d : powers(0, 7)) {
    const auto a = static_cast<float>(d);
    sliver.points.push_back({d, [a] { return stability_slivers(300, a); }, segment_kinds()[6].second, rays});
  }
  StabilitySweep& scale = sweep("scale", "Very small and very large meshes", "size of the mesh", "log");
  for (double d : powers(-30, 30)) {
    const auto f = static_cast<float>(d);
    scale.points.push_back({d, [f] { return scaled(stability_sphere(), {f, f, f}); }, from_boxes_away(2), rays});
  }
  StabilitySweep& kinds = sweep("segments", "Special segments", "how segments are drawn", "category");
  for (const auto& [name, maker] : segment_kinds())
    kinds.points.push_back({name, kinds.points.empty() ? std::function<SourceMesh()>(sphere) : nullptr, maker, rays});
  StabilitySweep& heights = sweep("self-height", "Segments from the object itself",
                                  "height of the origin, longest edges of its triangle", "log");
  for (double d : powers(-8, 2))
    heights.points.push_back({d,
                              heights.points.empty() ? std::function<SourceMesh()>([] {
                                return scaled(stability_sphere(24, 40), {1, 0.4f, 0.7f});
                              })
                                                     : nullptr,
                              nullptr, rays, above_a_triangle(d)});
  StabilitySweep& dents = sweep("self-meshes", "Segments from kinds of meshes", "mesh", "category");
  for (const auto& [name, mesh] : stability_kinds(2000))
    dents.points.push_back({name, [copy = mesh] { return copy; }, nullptr, rays, above_a_triangle(1e-3)});
  StabilitySweep& meshes = sweep("meshes", "Kinds of meshes, lines at their edges", "mesh", "category");
  for (const auto& [name, mesh] : stability_kinds(quick ? 2000 : 1000000))
    meshes.points.push_back({name, [copy = mesh] { return copy; }, segment_kinds()[6].second, rays});
  return sweeps;
}

void run_sweep(const StabilitySweep& sweep, const StabilityBakes& bakes,
               const std::function<void(size_t, const StabilityPoint&)>& visit) {
  std::optional<StabilityMesh> subject;
  std::string refused;
  std::function<SourceMesh()> mesh;
  for (size_t i = 0; i < sweep.points.size() && !interrupted(); ++i) {
    const StabilitySweep::Point& p = sweep.points[i];
    if (p.mesh) mesh = p.mesh;
    if (p.mesh || bakes.for_segments) {
      subject.reset();
      auto made = make_mesh(mesh(), p, bakes, 1077 + i);
      if (made) subject.emplace(std::move(*made));
      refused = made ? "" : made.error().message;
    }
    StabilityPoint point;
    if (subject) point = ask(*subject, p, 77 + i);
    point.refused = refused;
    visit(i, point);
  }
}

int run_stability(const StabilityOptions& options, const std::string& command, OutputFormat format) {
  std::error_code failed;
  std::filesystem::create_directories(options.folder, failed);
  if (failed) return print_error(options.folder + ": cannot be made: " + failed.message()), exit_code(ErrorCode::io);
  catch_interruptions();
  Json all{{"tool", "vc-bench stability"}, {"version", VCD_VERSION},
           {"command", command},           {"machine", describe_machine()},
           {"depth", options.bakes.depth}, {"for_segments", options.bakes.for_segments}};
  all["methods"] = kStabilityMethods;
  all["sweeps"] = Json::array();
  uint64_t wrong_proofs = 0, wrong_hierarchy = 0;
  for (const StabilitySweep& sweep : stability_sweeps(options.quick)) {
    Json json{{"id", sweep.id},
              {"title", sweep.title},
              {"parameter", sweep.parameter},
              {"scale", sweep.scale},
              {"points", Json::array()}};
    if (format == OutputFormat::text)
      std::printf("%s: wrong of resolved, depth %u\n  %-22s %8s %8s %16s %16s %16s %9s %8s %8s %14s\n",
                  sweep.title.c_str(), options.bakes.depth, sweep.parameter.substr(0, 22).c_str(), "rays", "blocked",
                  "proven", "hybrid", "256 samples", "hierarchy", "Embree", "ROBUST", "horizons");
    run_sweep(sweep, options.bakes, [&](size_t i, const StabilityPoint& p) {
      wrong_proofs += p.counts[0].wrong + p.wrong_proven + p.horizons.wrong;
      wrong_hierarchy += p.counts[kHierarchyMethod].wrong;
      Json point{{"x", sweep.points[i].x}, {"rays", p.rays}, {"blocked", p.blocked}, {"results", Json::object()}};
      const std::string x =
          sweep.points[i].x.is_string() ? sweep.points[i].x.get<std::string>() : sweep.points[i].x.dump();
      if (!p.refused.empty()) {
        for (size_t m = 0; m < kSidecarMethods; ++m) point["refused"][kStabilityMethods[m]] = p.refused;
        if (format == OutputFormat::text) std::printf("  %-22s refused: %s\n", x.c_str(), p.refused.c_str());
      } else {
        if (!p.no_hierarchy.empty()) point["refused"][kStabilityMethods[kHierarchyMethod]] = p.no_hierarchy;
        for (size_t m = 0; m < kStabilityMethodCount; ++m)
          if (m != kHierarchyMethod || p.no_hierarchy.empty())
            point["results"][kStabilityMethods[m]] = {{"wrong", p.counts[m].wrong}, {"resolved", p.counts[m].resolved}};
        const auto cell = [](const StabilityCounts& c) {
          return std::to_string(c.wrong) + " of " + std::to_string(c.resolved);
        };
        point["horizons"] = {{"wrong", p.horizons.wrong}, {"resolved", p.horizons.resolved}};
        const std::string hierarchy =
            p.no_hierarchy.empty() ? std::to_string(p.counts[kHierarchyMethod].wrong) : "none";
        if (format == OutputFormat::text)
          std::printf("  %-22s %8llu %8llu %16s %16s %16s %9s %8llu %8llu %14s\n", x.c_str(),
                      static_cast<unsigned long long>(p.rays), static_cast<unsigned long long>(p.blocked),
                      cell(p.counts[0]).c_str(), cell(p.counts[1]).c_str(), cell(p.counts[2]).c_str(),
                      hierarchy.c_str(), static_cast<unsigned long long>(p.counts[kEmbreeMethod].wrong),
                      static_cast<unsigned long long>(p.counts[kRobustMethod].wrong), cell(p.horizons).c_str());
        std::fflush(stdout);
      }
      json["points"].push_back(point);
    });
    all["sweeps"].push_back(json);
  }
  if (interrupted()) return print_error("interrupted"), exit_code(ErrorCode::runtime);
  const std::string text = all.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
  AtomicFile file(std::filesystem::path(options.folder) / "stability.json");
  file.append(std::as_bytes(std::span(text)));
  if (const auto written = file.commit(); !written)
    return print_error(written.error().message), exit_code(written.error().code);
  if (format == OutputFormat::json) print_json(all);
  if (wrong_proofs > 0) print_error(std::to_string(wrong_proofs) + " proven answers are wrong");
  if (wrong_hierarchy > 0) print_error(std::to_string(wrong_hierarchy) + " answers of hierarchies are wrong");
  if (wrong_proofs + wrong_hierarchy > 0) return exit_code(ErrorCode::difference);
  return kExitOk;
}

}  // namespace vcd::bench
