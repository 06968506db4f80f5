// Between the first and the second pass of the hierarchy's build: subtrees go where boxes become smaller.
#pragma once

#include "hierarchy/binary_tree.h"
#include "hierarchy/stop.h"

namespace vcd::baker {

// Takes subtrees out, and puts each back beside the node where the sum of all boxes' areas becomes least. All threads
// look for such places in the tree as it is; then the moves that gain most are made, as far as they do not touch each
// other; and again. The result does not depend on the threads. (Bittner, Hapala and Havran, "Fast insertion-based
// optimization of bounding volume hierarchies", 2013; Meister and Bittner, "Parallel reinsertion for bounding volume
// hierarchy optimization", 2018.) No path becomes longer than kMostLevels edges. Unchanged if it was stopped.
void reinsert(BinaryTree& tree, Stop& stop);

}  // namespace vcd::baker
