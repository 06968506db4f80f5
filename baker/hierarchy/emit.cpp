#include "hierarchy/emit.h"

#include <cstring>

namespace vcd::baker {
namespace {

class Emitter {
 public:
  Emitter(const WideTree& tree, HierarchySection& section) : tree_(tree), section_(section) {}

  // A node, its leaves, then what is below its other children. Returns the node's unit.
  uint32_t node(uint32_t index) {
    HierarchyNode node = tree_.nodes[index];
    const uint32_t unit = take(sizeof node);
    const uint32_t count = child_count(node);
    for (uint32_t i = 0; i < count; ++i)
      if (node.child[i] & kLeafChild) node.child[i] = leaf(node.child[i]);
    for (uint32_t i = 0; i < count; ++i)
      if (!(node.child[i] & kLeafChild)) node.child[i] = this->node(node.child[i]);
    put(unit, node);
    return unit;
  }

 private:
  uint32_t leaf(uint32_t child) {
    return (child & ~kUnitMask) | tree_.with_leaf(child, [&](const auto& leaf) {
      const uint32_t unit = take(sizeof leaf);
      put(unit, leaf);
      return unit;
    });
  }

  uint32_t take(size_t bytes) {
    const uint32_t unit = next_;
    next_ += static_cast<uint32_t>(bytes / kUnitBytes);
    return unit;
  }
  void put(uint32_t unit, const auto& content) { std::memcpy(&section_[unit], &content, sizeof content); }

  const WideTree& tree_;
  HierarchySection& section_;
  uint32_t next_ = kRootUnit;
};

}  // namespace

HierarchySection emit(const WideTree& tree, const Bounds& box, uint64_t triangle_count) {
  const uint64_t bytes = sizeof(HierarchyHeader) + tree.nodes.size() * sizeof(HierarchyNode) +
                         tree.small_leaves.size() * sizeof(SmallLeaf) + tree.large_leaves.size() * sizeof(LargeLeaf);
  if (bytes / kUnitBytes > kUnitMask) return {};
  HierarchyHeader header{};
  header.units = static_cast<uint32_t>(bytes / kUnitBytes);
  header.node_count = static_cast<uint32_t>(tree.nodes.size());
  header.leaf_count = static_cast<uint32_t>(tree.small_leaves.size() + tree.large_leaves.size());
  header.levels = tree.levels;
  header.triangle_count = triangle_count;
  for (size_t a = 0; a < 3; ++a) header.box_min[a] = box.min[a], header.box_max[a] = box.max[a];
  HierarchySection section(header.units);
  std::memcpy(section.data(), &header, sizeof header);
  Emitter(tree, section).node(0);
  return section;
}

}  // namespace vcd::baker
