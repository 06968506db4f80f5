// Segments as structure of arrays that the runtime owns: SegmentArrays is the view of them.
#pragma once

#include <algorithm>
#include <cstddef>

#include <vcd/runtime/segment_arrays.h>

#include "lookup/sample_bits.h"

namespace vcd {

template <size_t kMost>
struct SegmentColumns {
  alignas(64) float origin[3][kMost], direction[3][kMost], t_min[kMost], t_max[kMost];

  SegmentArrays view(size_t first, size_t count) const {
    return {{origin[0] + first, origin[1] + first, origin[2] + first},
            t_min + first,
            {direction[0] + first, direction[1] + first, direction[2] + first},
            t_max + first,
            count};
  }
  void set(size_t i, const Segment& s) {
    for (int a = 0; a < 3; ++a) origin[a][i] = s.origin[a], direction[a][i] = s.direction[a];
    t_min[i] = s.t_min, t_max[i] = s.t_max;
  }
  // Segments from one point, with t from 0 to 1.
  void set_origin(const float (&point)[3], size_t count) {
    for (int a = 0; a < 3; ++a) std::fill_n(origin[a], count, point[a]);
    std::fill_n(t_min, count, 0.0f);
    std::fill_n(t_max, count, 1.0f);
  }
  // Copies of the last of `count` segments up to a whole run. Returns the number of segments then.
  size_t pad(size_t count) {
    for (size_t i = count; i % kRun != 0; ++i) set(i, segment_at(view(count - 1, 1), 0));
    return (count + kRun - 1) / kRun * kRun;
  }
};

}  // namespace vcd
