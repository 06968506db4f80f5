// Variants timed side by side: interleaved, so that a drift of the machine's speed falls on all alike.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/describe.h"

namespace vcd::bench {

struct Variant {
  std::string name;
  std::function<void()> run;  // one repetition
};

struct Timing {
  std::string name;
  double minimum, median, maximum;  // seconds of one repetition
};

// Runs all variants in turn, `repetitions` times: each twice, and the second time is taken. The first finds the caches
// as the variant before it left them, which is worse after one that reads other memory than after one that reads the
// same.
std::vector<Timing> time_interleaved(const std::vector<Variant>& variants, int repetitions);

// seconds: at least one.
Timing summarize(std::string name, std::vector<double> seconds);

// By its median. There must be one.
const Timing& fastest(const std::vector<Timing>& timings);

// One line on standard output: nanoseconds for each of so many segments.
void print_timing(const Timing& timing, uint64_t segments);

// The same for each timing, and how many times faster it is than Embree's fastest, as lines and as JSON.
void print_timings(const std::vector<Timing>& timings, const Timing& best_embree, uint64_t segments);
tools::Json describe(const std::vector<Timing>& timings, const Timing& best_embree, uint64_t segments);

}  // namespace vcd::bench
