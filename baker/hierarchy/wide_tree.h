// Third pass of the hierarchy's build: wide nodes and leaves, not yet in the order of the section.
#pragma once

#include <cstdint>
#include <vector>

#include <vcd/format/hierarchy.h>

#include "hierarchy/binary_tree.h"
#include "hierarchy/collapse.h"

namespace vcd::baker {

// Nodes as in the section, but that a child's word holds an index into `nodes`, or one more than an index into
// `small_leaves` or `large_leaves` (kNoChild would be the leaf 0).
struct WideTree {
  std::vector<HierarchyNode> nodes;  // the root first, children behind their parents
  std::vector<SmallLeaf> small_leaves;
  std::vector<LargeLeaf> large_leaves;
  uint32_t levels = 0;

  // Calls f(leaf) with the leaf of a child's word, whichever kind it is.
  template <class F>
  auto with_leaf(uint32_t child, F&& f) const {
    const uint32_t index = (child & kUnitMask) - 1;
    return child & kLargeChild ? f(large_leaves[index]) : f(small_leaves[index]);
  }
};

inline uint32_t child_count(const HierarchyNode& node) {
  uint32_t count = 0;
  while (count < kNodeWidth && node.child[count] != kNoChild) ++count;
  return count;
}

WideTree make_wide_tree(const PreparedMesh& mesh, const BinaryTree& tree, const std::vector<Collapse>& choices);

}  // namespace vcd::baker
