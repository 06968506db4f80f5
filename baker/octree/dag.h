// Subtrees → the tree that is written: every block once.
#pragma once

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
  std::vector<uint32_t> top;  // with spare slot and padding
  std::vector<uint32_t> blocks256, blocks16, bricks;

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
  uint32_t intern_below_top(const Subtree& subtree, uint32_t first);
  uint32_t intern_block16(const Subtree& subtree, uint32_t first);

  uint32_t depth_;
  TreeShape shape_;
  std::vector<uint32_t> top_;
  Block256Pool blocks256_;
  Block16Pool blocks16_;
  BrickPool bricks_;
};

// The tree of a depth in which every cell is unclassified.
TreeArrays unclassified_tree(uint32_t depth);

}  // namespace vcd::baker
