// A segment in doubles, for boxes that it could meet.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <vcd/format/segment.h>

namespace vcd {

class WideRay {
 public:
  explicit WideRay(const Segment& s) : t_min_(s.t_min), t_max_(s.t_max) {
    for (size_t a = 0; a < 3; ++a)
      origin_[a] = s.origin[a], direction_[a] = s.direction[a], reciprocal_[a] = 1 / direction_[a];
  }

  // No box that the segment meets is missed: min and max are functions of the axis. Each distance is rounded three
  // times (difference, reciprocal, product: no over- or underflow between 2^-278 and 2^278), so it is within 4 e of
  // itself; e = 2^-53. Twice that is taken off: Ize, "Robust BVH ray traversal", 2013.
  template <class Min, class Max>
  bool may_meet(const Min& min, const Max& max) const {
    double enter = t_min_, leave = t_max_;
    for (size_t a = 0; a < 3; ++a) {
      const double low = min(a) - origin_[a], high = max(a) - origin_[a];
      if (direction_[a] == 0) {
        if (low > 0 || high < 0) return false;
        continue;
      }
      const double t0 = low * reciprocal_[a], t1 = high * reciprocal_[a];
      const double near = std::min(t0, t1), far = std::max(t0, t1);
      enter = std::max(enter, near - 0x1p-50 * std::abs(near));
      leave = std::min(leave, far + 0x1p-50 * std::abs(far));
    }
    return enter <= leave;
  }

 private:
  std::array<double, 3> origin_, direction_, reciprocal_;
  double t_min_, t_max_;
};

}  // namespace vcd
