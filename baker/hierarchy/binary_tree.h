// First pass of the hierarchy's build: a binary tree down to single triangles.
#pragma once

#include <cstdint>
#include <vector>

#include <vcd/baker/prepare.h>

#include "hierarchy/bounds.h"
#include "hierarchy/stop.h"

namespace vcd::baker {

struct BinaryNode {
  Bounds box;
  uint32_t first, count;  // its triangles, in BinaryTree::triangles
};

// The subtree of a node with t triangles takes 2 t - 1 entries: the node, its left subtree, its right subtree. So every
// node's place follows from the numbers of triangles, and threads need not agree on it.
struct BinaryTree {
  std::vector<BinaryNode> nodes;    // the root first
  std::vector<uint32_t> triangles;  // of the mesh, in the order of the leaves

  bool is_leaf(uint32_t node) const { return nodes[node].count == 1; }
  uint32_t left(uint32_t node) const { return node + 1; }
  uint32_t right(uint32_t node) const { return node + 2 * nodes[left(node)].count; }
};

// Splits by the surface-area heuristic over bins of centroids (Wald, "On fast construction of SAH-based bounding volume
// hierarchies", 2007). No path is longer than kMostLevels edges: where one would be, triangles are halved by number.
// Unfinished if it was stopped.
BinaryTree build_binary_tree(const PreparedMesh& mesh, Stop& stop);

}  // namespace vcd::baker
