// The steps in which the baker counts slopes: equal ones of the sine of the elevation, which are equal shares of the
// directions.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include <vcd/format/horizon.h>

namespace vcd::baker {

inline constexpr uint32_t kLevelsToZenith = 128;  // steps from the plane to straight up
inline constexpr uint32_t kLevels = 125;          // of them have a slope, at most 3.9
inline constexpr uint8_t kNever = 255;

using Levels = std::array<uint8_t, kHorizonSectors>;

inline double sine_of(uint32_t level) { return static_cast<double>(level) / kLevelsToZenith; }

// By level, rounded up to a float; the last is infinite.
struct LevelSlopes {
  std::array<float, kLevels + 1> slope;
  LevelSlopes() {
    for (uint32_t i = 0; i < kLevels; ++i)
      slope[i] = static_cast<float>(sine_of(i) / std::sqrt(1 - sine_of(i) * sine_of(i)) * (1 + 0x1p-22));
    slope[kLevels] = std::numeric_limits<float>::infinity();
  }
};
inline const LevelSlopes kLevelSlopes;
inline float slope_of(uint8_t level) { return kLevelSlopes.slope[level == kNever ? kLevels : level]; }

// The least level whose slope is not less.
inline uint8_t level_above(double slope) {
  uint32_t level = 0, most = kLevels;
  while (level < most) {
    const uint32_t middle = (level + most) / 2;
    if (double{kLevelSlopes.slope[middle]} < slope) level = middle + 1;
    else most = middle;
  }
  return level == kLevels ? kNever : static_cast<uint8_t>(level);
}

// What is answered by a sector above its slope, of all directions in it: all alike, and by their cosine to the normal.
struct Answered {
  double uniform = 0, cosine = 0;
  // What is best to store: most renderers draw directions by the cosine.
  double worth() const { return uniform + 3 * cosine; }
};
inline Answered answered_above(uint8_t level) {
  return level == kNever ? Answered{} : Answered{1 - sine_of(level), 1 - sine_of(level) * sine_of(level)};
}
inline Answered mean(const Levels& levels) {
  Answered sum;
  for (const uint8_t level : levels) {
    const auto [uniform, cosine] = answered_above(level);
    sum.uniform += uniform, sum.cosine += cosine;
  }
  return {sum.uniform / kHorizonSectors, sum.cosine / kHorizonSectors};
}

}  // namespace vcd::baker
