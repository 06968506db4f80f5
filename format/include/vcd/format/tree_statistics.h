// What a tree holds: cells of each class, and the node counts of the paper's Table 1.
#pragma once

#include <array>
#include <cstdint>

#include <vcd/format/tree.h>

namespace vcd {

struct TreeStatistics {
  std::array<uint64_t, 4> cells{};   // of each class, of the deepest stored level
  uint64_t nodes_unfolded = 0;       // nodes of the octree; a node whose descendants all agree is one leaf
  uint64_t nodes_folded = 0;         // words left when a node with sixteen leaf children is one word
  uint64_t nodes_shared = 0;         // words left when, moreover, equal groups of sixteen children of a level are one
  uint64_t unreferenced_blocks = 0;  // blocks that nothing refers to, of all pools, the uniform ones not counted
  uint64_t duplicate_blocks = 0;     // blocks that are equal to another one of their pool
  uint64_t mixed_groups = 0;         // groups of sixteen cells of bricks (not weighted) that differ

  bool operator==(const TreeStatistics&) const = default;
};

// Every index of the tree must be in range. Allocates about a quarter of the tree's size. The paper's node is a 32-bit
// word; 15 of the words are the roots.
TreeStatistics measure_tree(const TreeView& tree);

}  // namespace vcd
