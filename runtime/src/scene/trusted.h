// What the floats of a scene can hold: which segments may go through the hierarchy and the transforms. This is the one
// guard against overflow and underflow on the way from the world to a grid; spec/proofs.md, "The range of floats".
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <vcd/format/line_cell.h>
#include <vcd/format/segment.h>

#include "lookup/segment_columns.h"

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
  using namespace detail;
  const auto absolute = [](Float4 v) {
    return reinterpret_cast<Float4>(reinterpret_cast<Int4>(v) & (Int4{} + INT32_MAX));
  };
  const Float4 origin = absolute(load(s.origin)), direction = absolute(load(s.direction));  // and t, which is ballast
  if (sign_bits((origin <= all(kFarthest)) & (direction <= all(kFarthest))) != 7u) return false;
  if (sign_bits(direction >= all(kShortest)) == 0) return std::abs(s.t_min) <= kLatest && std::abs(s.t_max) <= kLatest;
  return !std::isnan(s.t_min) && !std::isnan(s.t_max);
}

// Whether the first `count` are.
inline bool are_trusted(const SegmentColumns<kChunk>& columns, size_t count) {
  const auto &o = columns.origin, &d = columns.direction;
  uint32_t doubtful = 0;
  for (size_t i = 0; i < count; ++i) {
    const float place = std::abs(o[0][i]) + std::abs(o[1][i]) + std::abs(o[2][i]),
                length = std::abs(d[0][i]) + std::abs(d[1][i]) + std::abs(d[2][i]);
    const float t = columns.t_min[i] + std::abs(columns.t_max[i]);  // no number if one of them is none
    doubtful |= !(place <= kFarthest) | !(length <= kFarthest) | !(length >= 4 * kShortest) | std::isnan(t);
  }
  if (doubtful == 0) return true;
  for (size_t i = 0; i < count; ++i)
    if (!is_trusted(segment_at(columns.view(i, 1), 0))) return false;
  return true;
}

}  // namespace vcd
