#include "dag.h"

#include <algorithm>

namespace vcd::baker {
namespace {

template <size_t kWords>
void intern_uniform(BlockPool<kWords>& pool, uint32_t step) {
  uint32_t words[kWords];
  for (uint32_t i = 0; i < kUniformBlocks; ++i) {
    std::fill_n(words, kWords, i * step);
    pool.intern(words);
  }
}

}  // namespace

TreeView TreeArrays::view() const {
  TreeView tree;
  tree.shape = shape;
  tree.top = top.data();
  tree.blocks256 = blocks256.data();
  tree.blocks16 = blocks16.data();
  tree.bricks = reinterpret_cast<const uint8_t*>(bricks.data());
  tree.block256_count = blocks256.size() / kBlock256Words;
  tree.block16_count = blocks16.size() / kBlock16Words;
  tree.brick_count = bricks.size() * 4 / kBrickBytes;
  return tree;
}

DagBuilder::DagBuilder(uint32_t depth) : depth_(depth), shape_(tree_shape(depth)) {
  top_.reserve(shape_.top_bytes() / 4);
  intern_uniform(bricks_, 0x55555555u);
  if (shape_.has_blocks16) intern_uniform(blocks16_, 1);
  if (shape_.has_blocks256) intern_uniform(blocks256_, 1);
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

uint32_t DagBuilder::intern_block16(const Subtree& subtree, uint32_t first) {
  uint32_t words[kBlock16Words];
  for (uint32_t i = 0; i < kBlock16Words; ++i) words[i] = intern_brick(subtree, first + i);
  return blocks16_.intern(words);
}

uint32_t DagBuilder::intern_below_top(const Subtree& subtree, uint32_t first) {
  return shape_.has_blocks16 ? intern_block16(subtree, first) : intern_brick(subtree, first);
}

void DagBuilder::append(const Subtree& subtree) {
  if (subtree.all) {
    top_.push_back(*subtree.all);  // the index of the uniform block, in each pool
    return;
  }
  if (!shape_.has_blocks256) {
    top_.push_back(intern_below_top(subtree, 0));
    return;
  }
  uint32_t words[kBlock256Words];
  const uint32_t step = static_cast<uint32_t>(subtree.bricks.size() / kBlock256Words);
  for (uint32_t i = 0; i < kBlock256Words; ++i) words[i] = intern_below_top(subtree, i * step);
  top_.push_back(blocks256_.intern(words));
}

TreeArrays DagBuilder::take() {
  TreeArrays arrays;
  arrays.depth = depth_;
  arrays.shape = shape_;
  arrays.top = std::move(top_);
  arrays.top.resize(shape_.top_bytes() / 4);  // spare slot and padding: zeros
  arrays.blocks256 = blocks256_.take();
  arrays.blocks16 = blocks16_.take();
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
