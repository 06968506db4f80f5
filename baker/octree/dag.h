// Subtrees → the tree that is written: every block once.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <vcd/format/tree.h>

#include "octree/block_pool.h"
#include "octree/subtree.h"

namespace vcd::baker {

// The arrays of a TREE section, owned.
struct TreeArrays {
  uint32_t depth = 0;
  TreeShape shape{};
  std::vector<uint32_t> top;                                   // with spare slot and padding
  std::array<std::vector<uint32_t>, kMostBlockLevels> blocks;  // empty beyond shape.block_levels
  std::vector<uint32_t> bricks;

  TreeView view() const;
};

// Subtrees must come in the order of the top table, so that the same classes give the same bytes. One thread.
class DagBuilder {
 public:
  explicit DagBuilder(uint32_t depth);
  void append(const Subtree& subtree);
  TreeArrays take();  // after all 15 · 16^T subtrees

 private:
  uint32_t intern_brick(const Subtree& subtree, uint32_t brick);
  uint32_t intern_block(const Subtree& subtree, uint32_t level, uint32_t first);

  uint32_t depth_;
  TreeShape shape_;
  std::vector<uint32_t> top_;
  std::array<BlockPool, kMostBlockLevels> blocks_;
  BlockPool bricks_;
};

// The tree of a depth in which every cell is unclassified.
TreeArrays unclassified_tree(uint32_t depth);

}  // namespace vcd::baker
