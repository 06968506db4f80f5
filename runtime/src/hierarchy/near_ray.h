// A segment as the float kernels see it: near the object, where its rounding is bounded by the object's size alone.
#pragma once

#include <algorithm>
#include <cmath>

#include "hierarchy/traced.h"

namespace vcd {

// The points origin + s · direction. The origin is where the segment begins or enters the object's box. One component
// of the direction, the greatest, is 1 or -1, so s is a length along that axis.
//
// All errors are counted in δ = 2^-20 M, M the greatest absolute coordinate of the object (u = 2^-24, so δ = 16 u M):
//   - The origin is rounded once from doubles, u M, whose own error is below 2^-27 M: 2^-53 of at most 2^26 M.
//   - A component of the direction is rounded once: u s, and s is at most 2 M in the box. Those below 2^-40 are taken
//   as
//     that, which turns the line by less than 2^-39 M.
//   - Boxes: reciprocal, 2 u · 2 M; origin times reciprocal, and δ, 2 u M; the multiply-add, 2 u M. Together with the
//     above less than 10 u M, so no box that the segment meets is missed if each is grown by δ; and one that is met by
//     these rules is met by the line if it is grown by 2 δ.
//   - Leaves: see `Leaf errors` in trace-inl.h.
struct NearRay {
  float origin[3], direction[3], reciprocal[3];
  float enter[3], leave[3];  // origin · reciprocal plus and minus δ · |reciprocal|
  float s_end;               // where the segment leaves the box or ends, and δ
  float first, last;         // s of the segment's own ends; far outside the box where they are not inside it
  float slack;               // δ
  uint32_t main, others[2];  // axes
  uint32_t near_plane[3];    // in a node, in floats: of the sides that the ray enters by
};

enum class Nearness {
  misses,  // the box; or the segment is empty
  near,    // the ray is made
  far,     // or not to be trusted: the reference decides
};

inline Nearness make_near_ray(const Traced& object, const Segment& segment, NearRay& ray) {
  const double t_min = segment.t_min, t_max = segment.t_max, reach = object.reach, slack = 0x1p-20 * reach;
  double length = 0, sum = 0, farthest = 0;
  for (int a = 0; a < 3; ++a) {
    const double component = std::abs(static_cast<double>(segment.direction[a]));
    length = std::max(length, component), sum += component;
    farthest += std::abs(static_cast<double>(segment.origin[a]));
  }
  // Written so that a NaN fails. 2^-80: a processor that takes subnormal numbers for zero changes nothing.
  if (!(t_min < t_max)) return Nearness::misses;
  if (!(farthest <= 0x1p24 * reach && length >= 0x1p-80 && sum <= 0x1p120)) return Nearness::far;
  double enter = t_min * length, leave = t_max * length;
  const double first = enter, last = leave, shrink = 1 / length;
  double direction[3];
  for (int a = 0; a < 3; ++a) {
    direction[a] = segment.direction[a] * shrink;
    if (!(std::abs(direction[a]) >= 0x1p-40)) direction[a] = std::copysign(0x1p-40, direction[a]);
    const double inverse = 1 / direction[a];
    const double low = (object.min[a] - slack - segment.origin[a]) * inverse;
    const double high = (object.max[a] + slack - segment.origin[a]) * inverse;
    enter = std::max(enter, std::min(low, high));
    leave = std::min(leave, std::max(low, high));
    ray.direction[a] = static_cast<float>(direction[a]);
    ray.reciprocal[a] = static_cast<float>(inverse);
  }
  if (!(enter <= leave)) return Nearness::misses;
  ray.slack = static_cast<float>(slack);
  ray.s_end = static_cast<float>(leave - enter + slack);
  ray.first = first >= enter ? 0.0f : static_cast<float>(-4 * reach);
  ray.last = last <= leave ? static_cast<float>(last - enter) : static_cast<float>(8 * reach);
  ray.main = 0;
  for (uint32_t a = 0; a < 3; ++a) {
    ray.origin[a] = static_cast<float>(segment.origin[a] + enter * direction[a]);
    const float product = ray.origin[a] * ray.reciprocal[a], grow = ray.slack * std::abs(ray.reciprocal[a]);
    ray.enter[a] = product + grow;
    ray.leave[a] = product - grow;
    ray.near_plane[a] = a * kNodeWidth + (direction[a] < 0 ? 3 * kNodeWidth : 0);
    if (std::abs(direction[a]) > std::abs(direction[ray.main])) ray.main = a;
  }
  ray.others[0] = (ray.main + 1) % 3, ray.others[1] = (ray.main + 2) % 3;
  return Nearness::near;
}

}  // namespace vcd
