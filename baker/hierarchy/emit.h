// Last pass of the hierarchy's build: the wide tree in the order of the section.
#pragma once

#include <vcd/baker/hierarchy.h>

#include "hierarchy/wide_tree.h"

namespace vcd::baker {

// Empty if it would have more units than a child's word can count.
HierarchySection emit(const WideTree& tree, const Bounds& box, uint64_t triangle_count);

}  // namespace vcd::baker
