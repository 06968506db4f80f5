// Whether a bundle of shadow rays could meet a box.
#pragma once

#include <span>

#include <vcd/format/segment.h>

#include "vec.h"

namespace vcd::render {

// All points origin + t · direction with 0 ≤ t ≤ 1 and the direction in the box about the directions of some segments
// that begin at one point.
class Beam {
 public:
  explicit Beam(std::span<const Segment> segments);  // at least one

  // False only if no segment of the beam meets the box, but for rounding.
  bool may_meet(const Box& box) const;

 private:
  struct Bound {  // a direction component's end: t · slope against an offset from the origin
    float slope, inverse;
  };
  Vec3 origin_;
  Bound low_[3], high_[3];
};

}  // namespace vcd::render
