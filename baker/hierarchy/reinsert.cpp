#include "hierarchy/reinsert.h"

#include <algorithm>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <vcd/format/hierarchy.h>

namespace vcd::baker {
namespace {

constexpr uint32_t kMostRounds = 8;
constexpr double kLeastGain = 1e-3;   // of a round, of the sum of all areas
constexpr uint32_t kMostLooks = 512;  // of a search: where all boxes overlap, each would look at all the others
constexpr uint32_t kNone = UINT32_MAX;

// A node of the tree in which subtrees move.
struct Linked {
  Bounds box;
  uint32_t parent, child[2];  // kNone: the root's parent, a leaf's children

  bool is_leaf() const { return child[0] == kNone; }
};

struct Move {
  uint32_t subtree, beside = kNone;  // kNone: it stays
  float gain = 0;
};

float area_together(Bounds a, const Bounds& b) {
  a.add(b);
  return a.half_area();
}

class Reinserter {
 public:
  explicit Reinserter(const BinaryTree& tree) {
    nodes_.resize(tree.nodes.size());
    link(tree, 0, kNone);
    is_candidate_.assign(nodes_.size(), true);
  }

  // Whether another round may be worth it.
  bool improve(Stop& stop) {
    const std::vector<Move> moves = find_moves(stop);
    if (stop.stopped()) return false;
    double sum = 0, gain = 0;
    for (const Linked& node : nodes_) sum += node.box.half_area();
    std::vector<bool> touched(nodes_.size());
    is_candidate_.assign(nodes_.size(), false);
    for (const Move& move : moves) {
      is_candidate_[move.subtree] = true;
      const uint32_t parent = nodes_[move.subtree].parent;
      if (parent == 0 || move.beside == parent) continue;
      const uint32_t ends[] = {move.subtree,          sibling(move.subtree), parent,
                               nodes_[parent].parent, move.beside,           nodes_[move.beside].parent};
      if (std::ranges::any_of(ends, [&](uint32_t node) { return touched[node]; })) continue;
      if (is_below(move.beside, move.subtree)) continue;
      for (const uint32_t node : ends) touched[node] = true, is_candidate_[node] = true;
      make(move);
      gain += move.gain;
    }
    return gain > kLeastGain * sum;
  }

  // Whether no path has become too long. from: the tree that was linked; to: empty.
  bool write(const BinaryTree& from, BinaryTree& to) const {
    to.nodes.reserve(from.nodes.size()), to.triangles.reserve(from.triangles.size());
    return write(from, to, 0, 0);
  }

 private:
  // As in the tree, a node is followed by its left subtree and its right one: its index is the same.
  void link(const BinaryTree& tree, uint32_t node, uint32_t parent) {
    const BinaryNode& n = tree.nodes[node];
    nodes_[node] = {n.box, parent, {kNone, kNone}};
    if (tree.is_leaf(node)) return;
    nodes_[node].child[0] = tree.left(node), nodes_[node].child[1] = tree.right(node);
    link(tree, tree.left(node), node), link(tree, tree.right(node), node);
  }

  bool write(const BinaryTree& from, BinaryTree& to, uint32_t node, uint32_t depth) const {
    const Linked& n = nodes_[node];
    const auto at = to.nodes.size();
    const auto first = static_cast<uint32_t>(to.triangles.size());
    to.nodes.push_back({n.box, first, 1});
    if (n.is_leaf()) return to.triangles.push_back(from.triangles[from.nodes[node].first]), true;
    if (depth == kMostLevels) return false;
    if (!write(from, to, n.child[0], depth + 1) || !write(from, to, n.child[1], depth + 1)) return false;
    to.nodes[at].count = static_cast<uint32_t>(to.triangles.size()) - first;
    return true;
  }

  std::vector<Move> find_moves(Stop& stop) const {
    std::vector<Move> moves(nodes_.size());
    using Range = tbb::blocked_range<size_t>;
    tbb::parallel_for(Range(0, nodes_.size(), 4096), [&](const Range& range) {
      if (stop.now()) return;
      Stack stack;
      for (size_t node = range.begin(); node < range.end(); ++node) {
        moves[node].subtree = static_cast<uint32_t>(node);
        if (is_candidate_[node] && node != 0 && nodes_[node].parent != 0) moves[node] = best_move(moves[node], stack);
      }
    });
    std::erase_if(moves, [](const Move& m) { return m.beside == kNone; });
    std::ranges::sort(
        moves, [](const Move& a, const Move& b) { return a.gain != b.gain ? a.gain > b.gain : a.subtree < b.subtree; });
    return moves;
  }

  // Nodes to look at, and what is saved above them: by the boxes that no longer hold the subtree, less those that then
  // do.
  using Stack = std::vector<std::pair<uint32_t, float>>;

  // Climbs from the subtree to the root, and looks into what hangs there on the other side, as far as that can gain.
  Move best_move(Move move, Stack& stack) const {
    const Bounds& box = nodes_[move.subtree].box;
    const uint32_t parent = nodes_[move.subtree].parent, own_sibling = sibling(move.subtree);
    const float area = box.half_area();
    float saved = nodes_[parent].box.half_area();
    Bounds without = nodes_[own_sibling].box;
    uint32_t looks = 0;
    for (uint32_t from = move.subtree, above = parent; above != kNone; from = above, above = nodes_[above].parent) {
      const uint32_t other = sibling(from);
      stack.assign(1, {other, saved});
      while (!stack.empty()) {
        if (++looks > kMostLooks) return move;
        const auto [node, saved_above] = stack.back();
        stack.pop_back();
        const Linked& n = nodes_[node];
        const float gain = saved_above - area_together(n.box, box);
        if (gain > move.gain && node != own_sibling) move.beside = node, move.gain = gain;
        const float saved_in_it = gain + n.box.half_area();
        if (n.is_leaf() || saved_in_it - area <= move.gain) continue;
        stack.emplace_back(n.child[0], saved_in_it), stack.emplace_back(n.child[1], saved_in_it);
      }
      if (above == parent) continue;
      without.add(nodes_[other].box);
      saved += nodes_[above].box.half_area() - without.half_area();
    }
    return move;
  }

  // The subtree takes its parent along; its sibling goes where the parent was.
  void make(const Move& move) {
    const uint32_t parent = nodes_[move.subtree].parent, above = nodes_[parent].parent;
    replace(parent, sibling(move.subtree));
    replace(move.beside, parent);
    nodes_[parent].child[nodes_[parent].child[0] == move.subtree] = move.beside;
    nodes_[move.beside].parent = parent;
    fit(parent);
    refit(above), refit(nodes_[parent].parent);
  }
  // As a child of its parent.
  void replace(uint32_t node, uint32_t by) {
    Linked& parent = nodes_[nodes_[node].parent];
    parent.child[parent.child[1] == node] = by;
    nodes_[by].parent = nodes_[node].parent;
  }
  // To the boxes of its children; whether that changes its own.
  bool fit(uint32_t node) {
    Linked& n = nodes_[node];
    Bounds box = nodes_[n.child[0]].box;
    box.add(nodes_[n.child[1]].box);
    return std::exchange(n.box, box) != box;
  }
  void refit(uint32_t node) {
    while (node != kNone && fit(node)) node = nodes_[node].parent;
  }

  uint32_t sibling(uint32_t node) const {
    const Linked& parent = nodes_[nodes_[node].parent];
    return parent.child[parent.child[0] == node];
  }
  bool is_below(uint32_t node, uint32_t top) const {
    while (node != kNone && node != top) node = nodes_[node].parent;
    return node == top;
  }

  std::vector<Linked> nodes_;          // the root first: it never moves
  std::vector<uint8_t> is_candidate_;  // all; then those that could not move, and those beside which something changed
};

}  // namespace

void reinsert(BinaryTree& tree, Stop& stop) {
  if (tree.nodes.size() < 2 || stop.now()) return;
  for (uint32_t rounds = kMostRounds; rounds > 0; rounds /= 2) {
    Reinserter reinserter(tree);
    for (uint32_t round = 0; round < rounds && reinserter.improve(stop); ++round) {
    }
    if (stop.stopped()) return;
    if (BinaryTree better; reinserter.write(tree, better)) return void(tree = std::move(better));
  }
}

}  // namespace vcd::baker
