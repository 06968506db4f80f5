// A segment as the float kernels see it: near the object, where its rounding is bounded by the object's size alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "hierarchy/traced.h"

namespace vcd {

// The points origin + s · direction. The origin is the segment's own or, of a segment that begins far away, a point of
// its line near the object. One component of the direction, the greatest, is 1 or -1, so s is a length along that axis.
//
// All errors are counted in δ = 2^-20 S = 16 u S, where S is the object's greatest absolute coordinate M and the
// origin's in sum, and u = 2^-24. No point of the object's box differs from the origin by more than S along an axis.
//   - The origin is the segment's own, or rounded once from doubles: 2 u S with the doubles' own error.
//   - A component of the direction is rounded twice, 2 u s, and s is at most S in the box. Those below 2^-40 are taken
//     as that, which turns the line by less than 2^-39 S.
//   - Boxes: the reciprocal, u S; origin times reciprocal, and δ, 2 u S; the multiply-add, u S. Together with the above
//     less than 9 u S, so no box that the segment meets is missed if each is grown by δ; and one that is met by these
//     rules is met by the line if it is grown by 2 δ.
//   - Leaves: see `Leaf errors` in trace-inl.h.
struct alignas(64) NearRay {
  float origin[4], direction[4];  // and a fourth lane that says nothing
  float reciprocal[4], enter[4];  // of the direction before it was rounded; origin · reciprocal plus δ · |reciprocal|
  float leave[4];                 // and minus
  uint32_t near_plane[4];         // in a node, in floats: of the sides that the ray enters by
  float s_begin, s_end;           // the segment in the object's box, grown by more than δ
  float first, last;              // s of the segment's own ends, or what is as far outside the box
  float first_error, last_error;  // 2^-22 of their size, 4 u: three roundings, and that of Σ side
  float slack;                    // δ
  float origin_error;             // 2 u S, or 0 if the origin is the segment's own
  uint32_t main, others[2];       // axes
};
static_assert(offsetof(NearRay, main) == 8 * 4 * sizeof(float));  // parts of four: near_rays-inl.h

enum class Nearness {
  misses,  // the box; or the segment is empty
  near,    // the ray is made
  far,     // or not to be trusted: the reference decides
};

// A point of the segment's line near the object, and its parameter.
struct Base {
  float origin[3], t;
};

// Of a segment whose origin is far from the object: where its line comes nearest to the object's middle.
inline Base far_base(const Traced& object, const Segment& segment) {
  double along = 0, square = 0;
  for (int a = 0; a < 3; ++a) {
    const double d = segment.direction[a];
    along += (0.5 * (double{object.min[a]} + object.max[a]) - segment.origin[a]) * d, square += d * d;
  }
  Base base{{}, static_cast<float>(along / square)};
  for (int a = 0; a < 3; ++a)
    base.origin[a] = static_cast<float>(segment.origin[a] + double{base.t} * segment.direction[a]);
  return base;
}

}  // namespace vcd
