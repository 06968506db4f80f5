// Segments against the horizons of the object that they begin on. The rule is clear_of_horizon() in
// <vcd/format/horizon.h>; the kernels say of each segment what it says.
#pragma once

#include <vcd/format/horizon.h>

#include "hierarchy/fan.h"
#include "lookup/sample_bits.h"

namespace vcd {

struct Horizons {
  HorizonView view{};  // or none
  HierarchyView hierarchy{};
};

// clear_of_horizon(), where there are any.
bool is_clear_scalar(const Horizons& horizons, const Segment& segment, uint32_t primitive) noexcept;
// Those of at most kChunk segments that are clear; primitives[i] is what segment i begins on.
SampleBits above_array_scalar(const Horizons& horizons, const Segment* segments, const uint32_t* primitives,
                              size_t count) noexcept;
// Those of the fan's live segments that are clear; all begin on one primitive.
SampleBits above_fan_scalar(const Horizons& horizons, const Fan& fan, uint32_t primitive) noexcept;

}  // namespace vcd
