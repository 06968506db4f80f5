// Many segments as structure of arrays.
#pragma once

#include <cstddef>

#include <vcd/format/segment.h>

namespace vcd {

// Segment i is {origin[0 … 2][i], t_min[i], direction[0 … 2][i], t_max[i]}; see <vcd/format/segment.h>. Any alignment.
struct SegmentArrays {
  const float* origin[3];
  const float* t_min;
  const float* direction[3];
  const float* t_max;
  size_t count;
};

inline Segment segment_at(const SegmentArrays& a, size_t i) {
  return {{a.origin[0][i], a.origin[1][i], a.origin[2][i]},
          a.t_min[i],
          {a.direction[0][i], a.direction[1][i], a.direction[2][i]},
          a.t_max[i]};
}

}  // namespace vcd
