#include "subtree.h"

namespace vcd::baker {
namespace {

class Builder {
 public:
  Builder(const CellSource& source, Workspace& workspace, Subtree& out)
      : source_(source), workspace_(workspace), out_(out), brick_level_(tree_shape(source.depth).levels - 2) {}

  void visit(const Cell& cell, uint32_t value) {
    if (source_.stop && source_.stop()) return;
    if (cell.level == brick_level_) {
      out_.bricks[brick_index(cell)] = value == kDeeper ? fill_brick(cell) : value;
      return;
    }
    for (uint32_t i = 0; i < 16; ++i) {
      const Cell child = cell.child(i);
      visit(child, value == kDeeper ? classify(child) : value);
    }
  }

 private:
  uint32_t classify(const Cell& cell) { return source_.classify(cell, workspace_); }

  // Where a cell of the brick level stands below its top cell: from block to block.
  uint32_t brick_index(const Cell& c) const {
    uint32_t index = 0;
    for (uint32_t low = tree_shape(source_.depth).block_levels; low-- > 0;)
      index = index * kBlockWords + row_major(c.s, c.t, c.u, c.v, low, 1);
    return index;
  }

  uint32_t fill_brick(const Cell& cell) {
    BrickWords words{};
    for (uint32_t i = 0; i < 16; ++i) {
      const Cell child = cell.child(i);
      const uint32_t value = classify(child);
      for (uint32_t j = 0; j < 16; ++j) {
        const Cell leaf = child.child(j);
        const uint32_t leaf_value = value == kDeeper ? classify(leaf) : value;
        const uint32_t at = row_major(leaf.s, leaf.t, leaf.u, leaf.v, 0, 2);
        words[at / 16] |= leaf_value << (2 * (at % 16));
      }
    }
    out_.words.push_back(words);
    return kDeeper + static_cast<uint32_t>(out_.words.size() - 1);
  }

  const CellSource& source_;
  Workspace& workspace_;
  Subtree& out_;
  uint32_t brick_level_;
};

}  // namespace

Subtree classify_subtree(const CellSource& source, const Cell& top, uint32_t value, Workspace& workspace) {
  Subtree subtree;
  if (value < kUniformBlocks) {
    subtree.all = value;
    return subtree;
  }
  subtree.bricks.resize(bricks_below_top(tree_shape(source.depth)));
  Builder(source, workspace, subtree).visit(top, value);
  return subtree;
}

}  // namespace vcd::baker
