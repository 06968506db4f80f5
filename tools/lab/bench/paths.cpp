#include "paths.h"

#include <algorithm>
#include <cstdio>
#include <tuple>

#include "common/describe.h"
#include "machine.h"
#include "paper_run.h"
#include "path_bench.h"
#include "render/census.h"
#include "render/sidecars.h"

namespace vcd::bench {

using namespace baker;
using namespace tools;
using namespace render;
namespace {

void print(const char* use, const PathTimes& times, uint64_t segments) {
  std::printf(" %s\n", use);
  for (const auto* group : {&times.embree, &times.vcd}) print_timings(*group, fastest(times.embree), segments);
}

void print(const PathComparison& c, const std::vector<PathWay>& ways) {
  using Count = unsigned long long;
  std::printf("%s: %llu segments, %.2f %% of them blocked; %llu answers of the hierarchy differ from Embree's\n",
              c.name.c_str(), Count{c.segments}, 100 * static_cast<double>(c.blocked) / static_cast<double>(c.segments),
              Count{c.differ});
  std::printf("  wrong in exact arithmetic, of %llu: Embree %llu", Count{c.judged}, Count{c.wrong_embree});
  for (size_t w = 0; w < ways.size(); ++w) std::printf("; %s %llu", ways[w].name.c_str(), Count{c.wrong[w]});
  std::printf("\n");
  print("single calls, path by path", c.single, c.segments);
  print("wavefronts of 4096 paths", c.wavefronts, c.segments);
}

// The same sidecars, asked in several ways.
struct OpenWays {
  std::vector<WorldSidecars> files;
  std::vector<PathWay> ways;  // the hierarchy first, with no look-up
};

Result<OpenWays> open_ways(const World& world, const std::vector<std::string>& paths) {
  OpenWays open;
  for (const auto& [name, look_up, by_horizons] :
       {std::tuple("hierarchy", LookUpFirst::never, false),
        std::tuple("look-ups, then hierarchy", LookUpFirst::always, false),
        std::tuple("look-ups as baked, then hierarchy", LookUpFirst::as_baked, false),
        std::tuple("look-ups as baked and horizons, then hierarchy", LookUpFirst::as_baked, true)}) {
    OpenOptions options;
    options.look_up = look_up;
    auto sidecars = open_sidecars(world, paths, options);
    if (!sidecars) return sidecars.error();
    if (!have_hierarchies(sidecars->objects))
      return Error{ErrorCode::usage, paths[0] + ": without a hierarchy of triangles; bake it again"};
    if (by_horizons && !some_has_horizons(sidecars->objects)) continue;
    open.ways.push_back({name, SidecarPaths(world, sidecars->objects, by_horizons)});
    open.files.push_back(std::move(*sidecars));
  }
  return open;
}

}  // namespace

int run_paths(const PathsOptions& options) {
  const auto fail = [](const Error& error) { return print_error(error.message), exit_code(error.code); };
  const auto world = world_of(options);
  if (!world) return fail(world.error());
  const auto open = open_ways(*world, options.sidecars);
  if (!open) return fail(open.error());
  const auto high = HighQualityCasters::build(*world);
  if (!high) return fail(high.error());

  const PathBench bench(*world, *high, open->ways, open->files[0].objects, options.repetitions);
  const std::vector<PathRay> rays = trace_paths(*world, {options.points, options.bounces, 7});
  std::vector<PathComparison> comparisons;
  const auto add = [&](const std::string& name, const auto& keep) {
    std::vector<PathRay> kept;
    std::ranges::copy_if(rays, std::back_inserter(kept), keep);
    if (!kept.empty()) comparisons.push_back(bench.compare(name, std::move(kept)));
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
    for (const PathComparison& c : comparisons) json["kinds"].push_back(describe(c, open->ways));
    print_json(json);
    return kExitOk;
  }
  std::printf("%s, one thread, %d interleaved repetitions: medians (minimum to maximum)\n",
              machine_description().c_str(), options.repetitions);
  for (const PathComparison& c : comparisons) print(c, open->ways);
  return kExitOk;
}

}  // namespace vcd::bench
