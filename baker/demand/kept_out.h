// What of a demand is kept out of bakes.
#pragma once

#include <span>
#include <vector>

#include <vcd/baker/demand.h>
#include <vcd/format/line_cell.h>

namespace vcd::baker {

// Whether a cell or the object's triangles have to be asked: the segment can be looked up, and the box alone does not
// answer it.
bool enters_box(const GridFrame& frame, const Segment& segment);

// Those that are kept out of bakes and enter the box.
std::vector<AskedSegment> kept_out_segments(const PreparedMesh& mesh, std::span<const AskedSegment> asked);

}  // namespace vcd::baker
