#include "dag.h"

#include <algorithm>

namespace vcd::baker {
namespace {

void intern_uniform(BlockPool& pool, uint32_t step) {
  uint32_t words[kBlockWords];
  for (uint32_t i = 0; i < kUniformBlocks; ++i) {
    std::fill_n(words, kBlockWords, i * step);
    pool.intern(words);
  }
}

}  // namespace

TreeView TreeArrays::view() const {
  TreeView tree;
  tree.shape = shape;
  tree.top = top.data();
  for (uint32_t k = 0; k < shape.block_levels; ++k) {
    tree.blocks[k] = blocks[k].data();
    tree.block_counts[k] = static_cast<uint32_t>(blocks[k].size() / kBlockWords);
  }
  tree.bricks = reinterpret_cast<const uint8_t*>(bricks.data());
  tree.brick_count = static_cast<uint32_t>(bricks.size() * 4 / kBrickBytes);
  return tree;
}

DagBuilder::DagBuilder(uint32_t depth) : depth_(depth), shape_(tree_shape(depth)) {
  top_.reserve(shape_.top_bytes() / 4);
  intern_uniform(bricks_, 0x55555555u);
  for (uint32_t k = 0; k < shape_.block_levels; ++k) intern_uniform(blocks_[k], 1);
}

uint32_t DagBuilder::intern_brick(const Subtree& subtree, uint32_t brick) {
  const uint32_t value = subtree.bricks[brick];
  if (value < kUniformBlocks) return value;
  if (value != kStatisticallyBlocked) return bricks_.intern(subtree.words[value - kDeeper].data());
  constexpr BrickWords kAllStatisticallyBlocked = [] {  // the one class that has no uniform block of its own
    BrickWords words{};
    for (uint32_t& word : words) word = 0xFFFFFFFF;
    return words;
  }();
  return bricks_.intern(kAllStatisticallyBlocked.data());
}

// What one word above that level refers to. first: of its bricks.
uint32_t DagBuilder::intern_block(const Subtree& subtree, uint32_t level, uint32_t first) {
  if (level == shape_.block_levels) return intern_brick(subtree, first);
  const uint32_t step = 1u << (4 * (shape_.block_levels - level - 1));
  uint32_t words[kBlockWords];
  for (uint32_t i = 0; i < kBlockWords; ++i) words[i] = intern_block(subtree, level + 1, first + i * step);
  return blocks_[level].intern(words);
}

void DagBuilder::append(const Subtree& subtree) {
  // A class is the index of its uniform block, in each pool.
  top_.push_back(subtree.all ? *subtree.all : intern_block(subtree, 0, 0));
}

TreeArrays DagBuilder::take() {
  TreeArrays arrays;
  arrays.depth = depth_;
  arrays.shape = shape_;
  arrays.top = std::move(top_);
  arrays.top.resize(shape_.top_bytes() / 4);  // spare slot and padding: zeros
  for (uint32_t k = 0; k < kMostBlockLevels; ++k) arrays.blocks[k] = blocks_[k].take();
  arrays.bricks = bricks_.take();
  return arrays;
}

TreeArrays unclassified_tree(uint32_t depth) {
  const TreeShape shape = tree_shape(depth);
  Subtree unclassified;
  unclassified.all = kUnclassified;
  DagBuilder dag(depth);
  for (uint32_t slot = 0; slot < shape.top_words(); ++slot) dag.append(unclassified);
  return dag.take();
}

}  // namespace vcd::baker
