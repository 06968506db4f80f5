// Variants timed side by side: interleaved, so that a drift of the machine's speed falls on all alike.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace vcd::bench {

struct Variant {
  std::string name;
  std::function<void()> run;  // one repetition
};

struct Timing {
  std::string name;
  double minimum, median, maximum;  // seconds of one repetition
};

// Runs every variant once unmeasured, then all in turn, `repetitions` times.
std::vector<Timing> time_interleaved(const std::vector<Variant>& variants, int repetitions);

// seconds: at least one.
Timing summarize(std::string name, std::vector<double> seconds);

// One line on standard output: nanoseconds for each of so many segments.
void print_timing(const Timing& timing, uint64_t segments);

}  // namespace vcd::bench
