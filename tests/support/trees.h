// Trees to be changed.
#pragma once

#include <cstring>
#include <vector>

#include "octree/dag.h"

namespace vcd::test {

inline baker::TreeArrays arrays_of(const TreeView& tree, uint32_t depth) {
  const auto words = [](const void* from, uint64_t bytes) {
    std::vector<uint32_t> copy(bytes / 4);
    if (bytes) std::memcpy(copy.data(), from, bytes);
    return copy;
  };
  const auto blocks = [&](size_t k) { return words(tree.blocks[k], tree.block_counts[k] * kBlockBytes); };
  return {depth,
          tree.shape,
          words(tree.top, tree.shape.top_bytes()),
          {blocks(0), blocks(1), blocks(2)},
          words(tree.bricks, tree.brick_count * kBrickBytes)};
}

}  // namespace vcd::test
