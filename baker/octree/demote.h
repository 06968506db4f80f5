// Demote-merge: a tree in fewer bytes that promises a little less, and nothing else.
#pragma once

#include <cstdint>

#include "octree/dag.h"

namespace vcd::baker {

struct Demoted {
  TreeArrays tree;
  uint64_t cells_lost = 0;  // that had a class and are unclassified now
};

// The tree in at most `budget_bytes` (TreeShape::bytes of it), by making cells unclassified, or blocked ones
// statistically blocked, which is always safe. Blocks that differ little become one that promises what both do: from
// the top down, bricks last. Unchanged if it fits; where not even the top table and the
// uniform blocks fit, those: all that was mixed below the top table is unclassified, and the caller must take a lower
// depth.
//
// threads: 0 for all; the result is the same for any number.
Demoted demote_merge(TreeArrays tree, uint64_t budget_bytes, unsigned threads = 0);

}  // namespace vcd::baker
