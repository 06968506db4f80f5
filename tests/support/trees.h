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
  return {depth,
          tree.shape,
          words(tree.top, tree.shape.top_bytes()),
          words(tree.blocks256, tree.block256_count * kBlock256Words * 4),
          words(tree.blocks16, tree.block16_count * kBlock16Words * 4),
          words(tree.bricks, tree.brick_count * kBrickBytes)};
}

}  // namespace vcd::test
