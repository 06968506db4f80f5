#include "hierarchy/wide_tree.h"

#include <algorithm>
#include <array>
#include <span>

namespace vcd::baker {
namespace {

// The triangles of a leaf over its distinct vertices, numbered as they come.
struct LeafMesh {
  std::array<uint32_t, kLargeVertices> vertex;
  uint32_t vertex_count = 0;
  std::array<std::array<uint8_t, 3>, kNodeWidth> corners;
  uint32_t triangle_count = 0;

  LeafMesh(const PreparedMesh& mesh, std::span<const uint32_t> triangles) {
    for (const uint32_t t : triangles) {
      for (size_t c = 0; c < 3; ++c) corners[triangle_count][c] = number_of(mesh.triangles[t][c]);
      ++triangle_count;
    }
  }

 private:
  uint8_t number_of(uint32_t index) {
    const auto end = vertex.begin() + vertex_count;
    const auto at = std::find(vertex.begin(), end, index);
    if (at == end) *at = index, ++vertex_count;
    return static_cast<uint8_t>(at - vertex.begin());
  }
};

template <uint32_t kVertices>
HierarchyLeaf<kVertices> make_leaf(const PreparedMesh& mesh, const LeafMesh& content, const Bounds& box) {
  HierarchyLeaf<kVertices> leaf{};
  for (uint32_t v = 0; v < kVertices; ++v) {
    const Position& p = mesh.positions[content.vertex[std::min(v, content.vertex_count - 1)]];
    for (size_t a = 0; a < 3; ++a) leaf.vertex[a][v] = p[a];
  }
  for (uint32_t t = 0; t < content.triangle_count; ++t)
    for (size_t c = 0; c < 3; ++c) leaf.corner[c][t] = content.corners[t][c];
  leaf.present = static_cast<uint16_t>((1u << content.triangle_count) - 1);
  for (size_t a = 0; a < 3; ++a) leaf.extent = std::max(leaf.extent, extent_above(box.min[a], box.max[a]));
  return leaf;
}

class Maker {
 public:
  Maker(const PreparedMesh& mesh, const BinaryTree& tree, const std::vector<Collapse>& choices)
      : mesh_(mesh), tree_(tree), choices_(choices) {}

  WideTree run() {
    node(0, 1);
    return std::move(wide_);
  }

 private:
  // The wide node of a binary node; level: its own, from 1 on. Returns its index.
  uint32_t node(uint32_t binary, uint32_t level) {
    wide_.levels = std::max(wide_.levels, level);
    const auto index = static_cast<uint32_t>(wide_.nodes.size());
    wide_.nodes.emplace_back();
    const std::vector<uint32_t> children = children_of(binary);
    for (uint32_t i = 0; i < kNodeWidth; ++i) {
      const Bounds box = i < children.size() ? tree_.nodes[children[i]].box : Bounds{};
      HierarchyNode& own = wide_.nodes[index];
      for (size_t a = 0; a < 3; ++a) own.min[a][i] = box.min[a], own.max[a][i] = box.max[a];
      own.child[i] = kNoChild;
    }
    for (uint32_t i = 0; i < children.size(); ++i) {
      const uint32_t child = choices_[children[i]].is_leaf() ? leaf(children[i]) : node(children[i], level + 1);
      wide_.nodes[index].child[i] = child;
    }
    return index;
  }

  // The binary nodes that become the children of a binary node's wide node.
  std::vector<uint32_t> children_of(uint32_t binary) const {
    std::vector<uint32_t> children;
    const uint32_t left = choices_[binary].of(1);
    if (left == 0) return {binary};  // a root that is a leaf
    collect(tree_.left(binary), left, children);
    collect(tree_.right(binary), kNodeWidth - left, children);
    return children;
  }
  void collect(uint32_t binary, uint32_t slots, std::vector<uint32_t>& children) const {
    const uint32_t left = slots == 1 ? 0 : choices_[binary].of(slots);
    if (left == 0) return children.push_back(binary);
    collect(tree_.left(binary), left, children);
    collect(tree_.right(binary), slots - left, children);
  }

  uint32_t leaf(uint32_t binary) {
    const BinaryNode& node = tree_.nodes[binary];
    std::array<uint32_t, kNodeWidth> triangles;
    const auto end = std::copy_n(tree_.triangles.begin() + node.first, node.count, triangles.begin());
    std::sort(triangles.begin(), end);
    const LeafMesh content(mesh_, {triangles.begin(), end});
    const auto add = [&](auto& leaves, auto&& leaf, uint32_t flags) {
      leaves.push_back(leaf);
      return flags | static_cast<uint32_t>(leaves.size());
    };
    return content.vertex_count <= kNodeWidth
               ? add(wide_.small_leaves, make_leaf<kNodeWidth>(mesh_, content, node.box), kLeafChild)
               : add(wide_.large_leaves, make_leaf<kLargeVertices>(mesh_, content, node.box), kLeafChild | kLargeChild);
  }

  const PreparedMesh& mesh_;
  const BinaryTree& tree_;
  const std::vector<Collapse>& choices_;
  WideTree wide_;
};

}  // namespace

WideTree make_wide_tree(const PreparedMesh& mesh, const BinaryTree& tree, const std::vector<Collapse>& choices) {
  return Maker(mesh, tree, choices).run();
}

}  // namespace vcd::baker
