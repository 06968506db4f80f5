// Does a segment meet a triangle? A filter in doubles that knows when it does not know, and the exact answer.
#pragma once

#include <array>

#include <vcd/baker/mesh.h>
#include <vcd/format/segment.h>

namespace vcd::baker {

using Triangle = std::array<Position, 3>;

// A segment in doubles, where products of up to six float-sized factors neither overflow nor underflow.
struct WideSegment {
  std::array<double, 3> origin, direction;
  double t_min, t_max;
};
WideSegment widen(const Segment& segment);

enum class Meeting { no, yes, doubtful };

// yes and no are certain. All numbers but the interval's ends finite, t_min < t_max.
Meeting filter_meeting(const WideSegment& segment, const Triangle& triangle);

// The same without a doubt, and slowly (microseconds). The triangle must have an area.
bool meets_exactly(const Segment& segment, const Triangle& triangle);

}  // namespace vcd::baker
