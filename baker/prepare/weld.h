// Bit-exact welding and cleaning. A weld by tolerance would close real gaps and so forge promises.
#pragma once

#include <vcd/baker/prepare.h>

namespace vcd {

// Fills in positions, triangles and the counts of dropped triangles.
void weld(SourceMesh&& source, PreparedMesh& mesh);

// True if the three points lie exactly on one line, decided without rounding (for differences that a double holds).
bool has_zero_area(const Position& a, const Position& b, const Position& c);

}  // namespace vcd
