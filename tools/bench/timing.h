// Variants timed side by side: interleaved, so that a drift of the machine's speed falls on all alike.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace vcd {

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

// "AMD EPYC, 2 threads; GCC 12.2.0; Embree 3.13.5": what figures should be read with.
std::string machine_description();

}  // namespace vcd
