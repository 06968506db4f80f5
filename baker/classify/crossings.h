// Which triangles of some clusters a line crosses, decided beyond rounding or not at all.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "classify/triangle_groups.h"

namespace vcd::baker {

struct Line {
  std::array<double, 3> from, to;  // on or outside the box's faces, grid units
};

struct Crossing {
  double at;  // along the line: 0 at its beginning, 1 at its end
  uint32_t triangle;
};

// The crossings, in order along the line. False if the line passes some triangle's edge or vertex too closely for
// double precision to tell on which side; then try another line.
bool crossings(const TriangleGroups& groups, const Candidates& candidates, const Line& line,
               std::vector<Crossing>& into);

}  // namespace vcd::baker
