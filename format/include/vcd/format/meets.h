// What a hit is: whether a segment meets a triangle, decided exactly.
#pragma once

#include <array>

#include <vcd/format/segment.h>

namespace vcd {

// Floats are dyadic rationals, so a segment and a triangle are exact data, and "some point of the segment is a point of
// the triangle" has one answer; this gives it. Triangles are closed, segments are open (spec/conventions.md, 1 to 4 and
// 20):
//   - a segment that meets an edge or a vertex alone meets the triangle, and so does one in its plane that overlaps it;
//   - a triangle that only touches t_min or t_max is not met;
//   - a direction of zero length is the point `origin`;
//   - a NaN in the interval, or t_min >= t_max, never meets anything; nor does a NaN or an infinity in origin or
//     direction.
//
// The corners must be finite and not on one line, in any order: prepare() drops all other triangles.
// A filter in doubles decides nearly all cases (some tens of nanoseconds); what it leaves in doubt is decided in
// integers (some microseconds). Neither allocates, and neither depends on the processor's mode for subnormal numbers.
using Triangle = std::array<std::array<float, 3>, 3>;  // corners
bool meets(const Segment& segment, const Triangle& triangle) noexcept;

// Whether anything can be met at all: the interval is not empty, and no coordinate is a NaN or an infinity.
bool can_meet(const Segment& segment) noexcept;

}  // namespace vcd
