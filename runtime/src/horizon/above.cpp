#include "horizon/above.h"

namespace vcd {
bool is_clear_scalar(const Horizons& horizons, const Segment& segment, uint32_t primitive) noexcept {
  return horizons.view && clear_of_horizon(horizons.view, horizons.hierarchy, segment, primitive);
}

SampleBits above_array_scalar(const Horizons& horizons, const Segment* segments, const uint32_t* primitives,
                              size_t count) noexcept {
  SampleBits clear{};
  for (size_t i = 0; i < count; ++i)
    clear.set(i, clear_of_horizon(horizons.view, horizons.hierarchy, segments[i], primitives[i]));
  return clear;
}

SampleBits above_fan_scalar(const Horizons& horizons, const Fan& fan, uint32_t primitive) noexcept {
  SampleBits clear{};
  for (size_t i : fan.live)
    clear.set(i, clear_of_horizon(horizons.view, horizons.hierarchy, segment_of(fan, i), primitive));
  return clear;
}

}  // namespace vcd
