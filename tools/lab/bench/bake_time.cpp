#include "bake_time.h"

#include <cstdio>

#include <vcd/baker/measure.h>

#include "common/describe.h"
#include "machine.h"
#include "timing.h"

namespace vcd::bench {

using namespace baker;
using namespace tools;
namespace {

struct MethodToTime {
  const char* name;
  Method method;
  uint32_t samples;
};
constexpr MethodToTime kMethods[] = {
    {"256 samples", Method::sampled, 256}, {"proven", Method::proven, 256}, {"hybrid", Method::hybrid, 0}};

struct TimedBake {
  std::vector<double> seconds;  // of the whole
  uint64_t rays = 0;
};

std::optional<Error> add_bake(const PreparedMesh& mesh, const BakeOptions& options, uint32_t one_in, TimedBake& timed) {
  const auto time = time_bake(mesh, options, one_in);
  if (!time) return time.error();
  timed.seconds.push_back(time->seconds);
  timed.rays = time->rays;
  return std::nullopt;
}

}  // namespace

int run_bake_time(const MeshToRead& file, const BakeTimeOptions& options, int repetitions, OutputFormat format) {
  const auto loaded = TracedMesh::load(file);
  if (!loaded) return print_error(loaded.error().message), exit_code(loaded.error().code);
  const PreparedMesh& mesh = loaded->mesh;
  catch_interruptions();
  Json all = Json::array();
  if (format == OutputFormat::text)
    std::printf(
        "%s: %zu triangles; %s, %u thread(s), scaled up from one in %u cells of the top table, medians of %d "
        "interleaved bakes\n"
        "  %-6s %-18s %10s %8s %14s\n",
        file.path.c_str(), mesh.triangles.size(), machine_description().c_str(), options.threads, options.one_in,
        repetitions, "depth", "method", "seconds", "faster", "rays");
  for (uint32_t depth : options.depths) {
    std::vector<TimedBake> timed(std::size(kMethods));
    for (int r = 0; r < repetitions; ++r)
      for (size_t m = 0; m < timed.size(); ++m) {
        BakeOptions bake_options;
        bake_options.method = kMethods[m].method, bake_options.samples = kMethods[m].samples;
        bake_options.depth = depth, bake_options.threads = options.threads;
        bake_options.stop = interrupted;
        if (auto error = add_bake(mesh, bake_options, options.one_in, timed[m]))
          return print_error(error->message), exit_code(error->code);
      }
    const double base = summarize("", timed[0].seconds).median;
    for (size_t m = 0; m < timed.size(); ++m) {
      const double seconds = summarize("", timed[m].seconds).median;
      all.push_back({{"depth", depth},
                     {"method", kMethods[m].name},
                     {"seconds", seconds},
                     {"faster", base / seconds},
                     {"rays", timed[m].rays}});
      if (format == OutputFormat::text)
        std::printf("  %-6u %-18s %10.3f %7.2fx %14llu\n", depth, kMethods[m].name, seconds, base / seconds,
                    static_cast<unsigned long long>(timed[m].rays));
    }
  }
  if (format == OutputFormat::json)
    print_json({{"tool", "vc-bench"},
                {"version", VCD_VERSION},
                {"machine", machine_description()},
                {"mesh", file.path},
                {"one_in", options.one_in},
                {"threads", options.threads},
                {"repetitions", repetitions},
                {"bakes", all}});
  return kExitOk;
}

}  // namespace vcd::bench
