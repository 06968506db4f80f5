// Second pass of the hierarchy's build: which nodes of the binary tree become wide nodes, and which become leaves.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <vcd/format/hierarchy.h>

#include "hierarchy/binary_tree.h"
#include "hierarchy/stop.h"

namespace vcd::baker {

// How a binary node is best made into at most s children of a wide node, for s = 1 … kNodeWidth.
struct Collapse {
  // For s > 1: so many of them come from the left subtree, the others from the right one; 0: it is best one child.
  // For s = 1, likewise, how the kNodeWidth children of the wide node that it becomes are shared out; 0: it is a leaf.
  std::array<uint8_t, kNodeWidth> left;

  bool is_leaf() const { return left[0] == 0; }
  uint8_t& of(uint32_t slots) { return left[slots - 1]; }
  uint8_t of(uint32_t slots) const { return left[slots - 1]; }
};

// Of each binary node, by dynamic programming over the surface-area heuristic, in which a wide node and a leaf cost the
// same; leaves are rather full, though. (Pinter, "Heuristic BVH collapse", and Ylitie, Karras and Laine, "Efficient
// incoherent ray traversal on GPUs through compressed wide BVHs", 2017.) Unfinished if it was stopped.
std::vector<Collapse> choose_collapse(const PreparedMesh& mesh, const BinaryTree& tree, Stop& stop);

}  // namespace vcd::baker
