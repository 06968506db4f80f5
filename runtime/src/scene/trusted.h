// What the floats of a scene can hold: which segments may go through the hierarchy and the transforms. This is the one
// guard against overflow and underflow on the way from the world to a grid; spec/proofs.md, "The range of floats".
#pragma once

#include <algorithm>
#include <cmath>

#include <vcd/format/segment.h>

namespace vcd {

// Limits in the world. Instances whose boxes reach beyond kFarthest are met by every segment.
inline constexpr float kFarthest = 0x1p40f;   // of coordinates, and of the components of directions
inline constexpr float kShortest = 0x1p-30f;  // of a direction's longest component, unless t stays below kLatest
inline constexpr float kLatest = 0x1p70f;
// By so much all boxes are grown; and smaller components of directions, zero too, count as this. So a segment that is
// trusted is near a box at |t| <= 2 · kFarthest / kShortest = 2^71 only, and is moved by at most 2^72 · kSmallest
// there.
inline constexpr float kRoom = 0x1p-30f;
inline constexpr float kSmallest = 0x1p-110f;
static_assert(4 * kFarthest / kShortest * kSmallest <= kRoom && 2 * kLatest * kSmallest <= kRoom);

inline float inverse_of(float direction) {
  return 1 / std::copysign(std::max(std::abs(direction), kSmallest), direction);
}

// False for NaNs, too. Infinite t are fine.
inline bool is_trusted(const Segment& s) {
  bool near = true, is_long = false;
  for (int a = 0; a < 3; ++a) {
    const float place = std::abs(s.origin[a]), length = std::abs(s.direction[a]);
    near &= (place <= kFarthest) & (length <= kFarthest);
    is_long |= length >= kShortest;
  }
  const float begin = std::abs(s.t_min), end = std::abs(s.t_max);
  const bool numbers = (begin >= 0) & (end >= 0), early = (begin <= kLatest) & (end <= kLatest);
  return near & numbers & (is_long | early);
}

}  // namespace vcd
