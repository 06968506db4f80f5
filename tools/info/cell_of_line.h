// The cell of a line through a point of an object, and what its tree says of it.
#pragma once

#include <array>
#include <optional>

#include <vcd/format/contents.h>
#include <vcd/format/line_cell.h>

namespace vcd::tools {

struct CellOfLine {
  LineCell line;
  CellClass cell;  // blocked: by a proof; of objects that were baked by sampling statistically_blocked instead
};

// Nothing where the line misses the box. point and direction are in the object's frame; the direction is not zero.
std::optional<CellOfLine> cell_of_line(const ObjectContents& object, const std::array<double, 3>& point,
                                       const std::array<double, 3>& direction);

}  // namespace vcd::tools
