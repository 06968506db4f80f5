#include "timing.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "common/seconds_since.h"

namespace vcd::bench {
namespace {

double seconds_of(const std::function<void()>& run) {
  const auto start = std::chrono::steady_clock::now();
  run();
  return seconds_since(start);
}

}  // namespace

std::vector<Timing> time_interleaved(const std::vector<Variant>& variants, int repetitions) {
  std::vector<std::vector<double>> seconds(variants.size());
  for (int r = 0; r < repetitions; ++r)
    for (size_t v = 0; v < variants.size(); ++v) {
      variants[v].run();
      seconds[v].push_back(seconds_of(variants[v].run));
    }
  std::vector<Timing> timings;
  for (size_t v = 0; v < variants.size(); ++v) timings.push_back(summarize(variants[v].name, seconds[v]));
  return timings;
}

Timing summarize(std::string name, std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  return {std::move(name), seconds.front(), seconds[seconds.size() / 2], seconds.back()};
}

const Timing& fastest(const std::vector<Timing>& timings) {
  return *std::min_element(timings.begin(), timings.end(),
                           [](const Timing& a, const Timing& b) { return a.median < b.median; });
}

void print_timing(const Timing& t, uint64_t segments) {
  const double scale = 1e9 / static_cast<double>(segments);
  std::printf("  %-40s %7.1f ns a segment (%.1f to %.1f)\n", t.name.c_str(), t.median * scale, t.minimum * scale,
              t.maximum * scale);
}

void print_timings(const std::vector<Timing>& timings, const Timing& best_embree, uint64_t segments) {
  const double scale = 1e9 / static_cast<double>(segments);
  for (const Timing& t : timings)
    std::printf("  %-46s %7.1f ns a segment (%.1f to %.1f) %6.2f times Embree's best\n", t.name.c_str(),
                t.median * scale, t.minimum * scale, t.maximum * scale, best_embree.median / t.median);
}

tools::Json describe(const std::vector<Timing>& timings, const Timing& best_embree, uint64_t segments) {
  const double scale = 1e9 / static_cast<double>(segments);
  tools::Json json = tools::Json::array();
  for (const Timing& t : timings)
    json.push_back({{"name", t.name},
                    {"median_ns", t.median * scale},
                    {"minimum_ns", t.minimum * scale},
                    {"maximum_ns", t.maximum * scale},
                    {"speed_up", best_embree.median / t.median}});
  return json;
}

}  // namespace vcd::bench
