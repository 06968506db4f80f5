// Demote-merge: a tree in fewer bytes that promises a little less, and nothing else.
#pragma once

#include <cstdint>

#include "octree/dag.h"

namespace vcd {

// The tree in at most `budget_bytes` (TreeShape::bytes of it), by making cells unclassified, or blocked ones statistically
// blocked, which is always safe. Bricks that differ little become one that promises what both do; where 16-way and
// 256-way blocks alone take too much, those that promise least become unclassified. Unchanged if it fits; as small as can
// be, the top table and uniform blocks, if nothing fits. The same tree and budget give the same result for any number
// of threads.
TreeArrays demote_merge(TreeArrays tree, uint64_t budget_bytes);

}  // namespace vcd
