// Bit-exact welding and cleaning. A weld by tolerance would close real gaps and so forge promises.
#pragma once

#include <vcd/baker/prepare.h>

namespace vcd::baker {

// Fills in positions, triangles and the counts of dropped triangles.
void weld(SourceMesh&& source, PreparedMesh& mesh);

// True if the three points lie on one line in exact arithmetic.
bool has_zero_area(const Position& a, const Position& b, const Position& c);

}  // namespace vcd::baker
