// A segment as the float kernels see it: near the object, where its rounding is bounded by the object's size alone.
#pragma once

#include <algorithm>
#include <cmath>

#include "hierarchy/traced.h"

namespace vcd {

// The points origin + s · direction. The origin is where the segment begins or, nearly, where it enters the object's
// box. One component of the direction, the greatest, is 1 or -1, so s is a length along that axis.
//
// All errors are counted in δ = 2^-20 M = 16 u M, where M is the greatest absolute coordinate of the object and
// u = 2^-24:
//   - The origin is the segment's own, or rounded once from doubles: 2 u M with the doubles' own error.
//   - A component of the direction is rounded twice, 2 u s, and s is at most 2.1 M in the box. Those below 2^-40 are
//     taken as that, which turns the line by less than 2^-38 M.
//   - Boxes: the reciprocal, u · 2.1 M; origin times reciprocal, and δ, 2.1 u M; the multiply-add, 2.1 u M. Together
//     with the above less than 13 u M, so no box that the segment meets is missed if each is grown by δ; and one that
//     is met by these rules is met by the line if it is grown by 2 δ.
//   - Leaves: see `Leaf errors` in trace-inl.h.
struct alignas(64) NearRay {
  float origin[4], direction[4];  // and a fourth lane that says nothing
  float reciprocal[4], enter[4];  // 1 / direction; origin · reciprocal plus δ · |reciprocal|
  float leave[4];                 // and minus
  uint32_t near_plane[4];         // in a node, in floats: of the sides that the ray enters by
  float s_end;                    // where the segment has left the box or has ended
  float first, last;              // s of the segment's own ends; far outside the box where they are not inside it
  float slack;                    // δ
  float origin_error;             // 2 u M, or 0 if the origin is the segment's own
  float last_error;               // of `last`
  uint32_t main, others[2];       // axes
};

enum class Nearness {
  misses,  // the box; or the segment is empty
  near,    // the ray is made
  far,     // or not to be trusted: the reference decides
};

// A point of the segment's line near the object, and its parameter.
struct Base {
  float origin[3], t;
  bool is_own;  // the segment's origin, and 0
};

// Of a segment whose origin is far from the object: where its line comes nearest to the object's middle.
inline Base far_base(const Traced& object, const Segment& segment) {
  double along = 0, square = 0;
  for (int a = 0; a < 3; ++a) {
    const double d = segment.direction[a];
    along += (0.5 * (double{object.min[a]} + object.max[a]) - segment.origin[a]) * d, square += d * d;
  }
  Base base{{}, static_cast<float>(along / square), false};
  for (int a = 0; a < 3; ++a)
    base.origin[a] = static_cast<float>(segment.origin[a] + double{base.t} * segment.direction[a]);
  return base;
}

}  // namespace vcd
