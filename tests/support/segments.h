#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>

#include <vcd/format/segment.h>

namespace vcd::test {

// Whether its line is: the interval may be anything.
inline bool is_finite(const Segment& s) {
  const auto finite = [](float x) { return std::isfinite(x); };
  return std::all_of(std::begin(s.origin), std::end(s.origin), finite) &&
         std::all_of(std::begin(s.direction), std::end(s.direction), finite);
}

}  // namespace vcd::test
