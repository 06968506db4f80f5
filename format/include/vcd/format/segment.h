// The question and the answer.
#pragma once

#include <cstdint>

namespace vcd {

// All points origin + t * direction with t in the open interval (t_min, t_max), in the object's own frame and unit.
// The direction has any length; for "is q visible from p?" take origin p, direction q - p, interval (0, 1).
struct Segment {
  float origin[3];
  float t_min;
  float direction[3];
  float t_max;
};
static_assert(sizeof(Segment) == 32);

// Numeric values are those of the file's cells and of the C API.
enum class Visibility : uint8_t {
  clear = 0,         // a promise: no triangle of the object meets the segment
  blocked = 1,       // a promise: some triangle of the object meets the segment
  unclassified = 2,  // no promise: ask the object's hierarchy, or the renderer's own
};

}  // namespace vcd
