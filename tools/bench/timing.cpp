#include "timing.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include <embree3/rtcore.h>

namespace vcd {
namespace {

double seconds_of(const std::function<void()>& run) {
  const auto start = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string processor_name() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

}  // namespace

std::vector<Timing> time_interleaved(const std::vector<Variant>& variants, int repetitions) {
  std::vector<std::vector<double>> seconds(variants.size());
  for (const Variant& variant : variants) variant.run();
  for (int r = 0; r < repetitions; ++r)
    for (size_t v = 0; v < variants.size(); ++v) seconds[v].push_back(seconds_of(variants[v].run));
  std::vector<Timing> timings;
  for (size_t v = 0; v < variants.size(); ++v) {
    std::sort(seconds[v].begin(), seconds[v].end());
    timings.push_back({variants[v].name, seconds[v].front(), seconds[v][seconds[v].size() / 2], seconds[v].back()});
  }
  return timings;
}

std::string machine_description() {
  return processor_name() + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads; " +
#ifdef __clang__
         "Clang " __clang_version__
#else
         "GCC " __VERSION__
#endif
         "; Embree " RTC_VERSION_STRING;
}

}  // namespace vcd
