// What a bake will cost and be worth, before it is done.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <vcd/baker/horizon.h>

namespace vcd::baker {

struct DepthForecast {
  uint32_t depth;
  uint64_t bytes;          // of the tree, before demote-merge
  double seconds;          // of the bake on the threads at hand; the probe and the audit are not in it
  double resolved;         // share of all cells that are clear or blocked
  double resolved_shadow;  // share of segments that look like shadow rays and pierce the box: isotropic ones, as light
                           // from all around sends them to points all around
  double gain;  // time of tracing these segments one by one, divided by that of looking up and tracing the rest
};

struct Plan {
  std::vector<DepthForecast> forecasts;     // of depths 1, 2, …
  uint32_t depth = 0;                       // the one that was picked; 0: a sidecar would not pay
  std::string reason;                       // for that, a clause
  double seconds = 0;                       // that the probe took
  std::optional<HorizonForecast> horizons;  // if they were asked for, of an object that can have them
};

}  // namespace vcd::baker
