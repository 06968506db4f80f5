// What all cells of a box of line space have in common.
#pragma once

#include <cstdint>

#include <vcd/format/tree.h>

namespace vcd {

// Of one face pair, the cells from low to high, both included, in cells of the deepest level: s, t, u, v.
struct CellRange {
  uint32_t pair;
  uint32_t low[4], high[4];
};

// Clear or blocked if all of them are, with what counts as blocked in this tree; else unclassified, also where it would
// take long to tell.
Visibility range_class(const TreeView& tree, const CellRange& range);

}  // namespace vcd
