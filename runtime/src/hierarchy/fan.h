// Segments from one point.
#pragma once

#include <cstddef>

#include "hierarchy/traced.h"
#include "lookup/sample_bits.h"

namespace vcd {

// Segment i of those in `live` runs from origin to origin + {direction[0][i], direction[1][i], direction[2][i]}, both
// ends excluded. count is at most kChunk; the arrays are readable up to a multiple of kRun.
struct Fan {
  float origin[3];
  const float* direction[3];
  size_t count;
  SampleBits live;
};

inline Segment segment_of(const Fan& fan, size_t i) {
  return {{fan.origin[0], fan.origin[1], fan.origin[2]},
          0.0f,
          {fan.direction[0][i], fan.direction[1][i], fan.direction[2][i]},
          1.0f};
}

// Those that some triangle meets: what occluded_scalar() says of each.
SampleBits occluded_array_scalar(const Traced& object, const Segment* segments, const SampleBits& live) noexcept;
SampleBits occluded_fan_scalar(const Traced& object, const Fan& fan) noexcept;

}  // namespace vcd
