#include "timing.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

namespace vcd::bench {
namespace {

double seconds_of(const std::function<void()>& run) {
  const auto start = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

std::vector<Timing> time_interleaved(const std::vector<Variant>& variants, int repetitions) {
  std::vector<std::vector<double>> seconds(variants.size());
  for (const Variant& variant : variants) variant.run();
  for (int r = 0; r < repetitions; ++r)
    for (size_t v = 0; v < variants.size(); ++v) seconds[v].push_back(seconds_of(variants[v].run));
  std::vector<Timing> timings;
  for (size_t v = 0; v < variants.size(); ++v) timings.push_back(summarize(variants[v].name, seconds[v]));
  return timings;
}

Timing summarize(std::string name, std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  return {std::move(name), seconds.front(), seconds[seconds.size() / 2], seconds.back()};
}

void print_timing(const Timing& t, uint64_t segments) {
  const double scale = 1e9 / static_cast<double>(segments);
  std::printf("  %-40s %7.1f ns a segment (%.1f to %.1f)\n", t.name.c_str(), t.median * scale, t.minimum * scale,
              t.maximum * scale);
}

}  // namespace vcd::bench
