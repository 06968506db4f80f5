#include "hierarchy/reinsert.h"

#include <algorithm>
#include <array>
#include <new>
#include <numeric>
#include <span>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <vcd/format/aligned_bytes.h>
#include <vcd/format/hierarchy.h>

#include "hierarchy/both_sides.h"

namespace vcd::baker {
namespace {

constexpr uint32_t kMostRounds = 8;
constexpr double kLeastGain = 1e-3;   // of a round, of the sum of all areas
constexpr uint32_t kMostLooks = 512;  // of a search: where all boxes overlap, each would look at all the others
constexpr uint32_t kNone = UINT32_MAX;

// The boxes of a node's children: a search looks at both, in one line of the cache.
struct alignas(64) Pair {
  Box box[2];
};

// Where a node hangs.
struct Slot {
  uint32_t parent = kNone, side = 0;
};

struct Move {
  uint32_t subtree, beside = kNone;  // kNone: it stays
  float gain = 0;
};

class Reinserter {
 public:
  // The tree has two triangles or more.
  explicit Reinserter(const BinaryTree& tree)
      : inner_count_(tree.triangles.size() - 1),
        memory_(allocate_aligned(inner_count_ * sizeof(Pair))),
        pairs_(reinterpret_cast<Pair*>(memory_.data.get())),
        children_(inner_count_),
        slots_(tree.nodes.size()),
        marks_(tree.nodes.size()) {
    if (!pairs_) throw std::bad_alloc();
    link(tree, 0, kRoot);
    for (const BinaryNode& node : tree.nodes) areas_ += Box::of(node.box).half_area();
    candidates_.resize(slots_.size() - 1);
    std::iota(candidates_.begin(), candidates_.end(), kRoot + 1);
  }

  // Whether another round may be worth it.
  bool improve(Stop& stop) {
    find_moves(stop);
    if (stop.stopped()) return false;
    double gain = 0;
    const auto touched = [&](uint32_t node) { return marks_[node].touched; };
    for (const Move& move : moves_) {
      marks_[move.subtree].again = true;
      if (touched(move.subtree) || touched(move.beside)) continue;  // most: the rest is slow to find
      const uint32_t parent = slots_[move.subtree].parent;
      if (parent == kRoot || move.beside == parent) continue;
      const uint32_t ends[] = {move.subtree,          sibling(move.subtree), parent,
                               slots_[parent].parent, move.beside,           slots_[move.beside].parent};
      if (std::ranges::any_of(ends, touched)) continue;
      if (is_below(move.beside, move.subtree)) continue;
      for (const uint32_t node : ends) marks_[node] = {true, true};
      make(move);
      gain += move.gain;
    }
    candidates_.clear();
    for (uint32_t node = kRoot + 1; node < marks_.size(); ++node)
      if (std::exchange(marks_[node], {}).again) candidates_.push_back(node);
    areas_ -= gain;
    return gain > kLeastGain * areas_;
  }

  // Into the tree that was linked, unless a path has become too long.
  bool write(BinaryTree& tree) {
    triangles_.resize(inner_count_);
    if (!count(kRoot, 0)) return false;
    const std::vector<uint32_t> triangles = tree.triangles;
    write(triangles, kRoot, Bounds(tree.nodes[0].box), 0, 0, tree);
    return true;
  }

 private:
  // Inner nodes come first, in the tree's order, then the leaves in theirs.
  static constexpr uint32_t kRoot = 0;
  bool is_leaf(uint32_t node) const { return node >= inner_count_; }
  uint32_t leaf(uint32_t first_triangle) const { return static_cast<uint32_t>(inner_count_) + first_triangle; }

  // A node of t triangles has t - 1 inner nodes, itself among them.
  void link(const BinaryTree& tree, uint32_t of_tree, uint32_t node) {
    const uint32_t left = tree.left(of_tree), right = tree.right(of_tree);
    const auto link_child = [&](uint32_t child, uint32_t inner, Slot slot) {
      const BinaryNode& n = tree.nodes[child];
      const bool is_last = tree.is_leaf(child);
      hang(is_last ? leaf(n.first) : inner, slot, Box::of(n.box));
      if (!is_last) link(tree, child, inner);
    };
    both_sides(
        tree.nodes[of_tree].count,
        [&] {
          link_child(left, node + 1, {node, 0});
        },
        [&] {
          link_child(right, node + tree.nodes[left].count, {node, 1});
        });
  }

  // The triangles of an inner node and of those below it. Whether no path has become too long.
  bool count(uint32_t node, uint32_t depth) {
    if (depth == kMostLevels) return false;
    bool fits[2];
    const auto count_child = [&](size_t side) {
      const uint32_t child = children_[node][side];
      fits[side] = is_leaf(child) || count(child, depth + 1);
    };
    // Subtrees of an upper node are large.
    both_sides(
        depth < 8 ? kOwnTask : 0, [&] { count_child(0); }, [&] { count_child(1); });
    triangles_[node] = triangles_of(children_[node][0]) + triangles_of(children_[node][1]);
    return fits[0] && fits[1];
  }
  uint32_t triangles_of(uint32_t node) const { return is_leaf(node) ? 1 : triangles_[node]; }

  void write(std::span<const uint32_t> triangles, uint32_t node, const Bounds& box, uint32_t first, uint32_t at,
             BinaryTree& tree) const {
    tree.nodes[at] = {box, first, triangles_of(node)};
    if (is_leaf(node)) return void(tree.triangles[first] = triangles[node - leaf(0)]);
    const std::array<uint32_t, 2> child = children_[node];
    const Pair& pair = pairs_[node];
    const uint32_t left = triangles_of(child[0]);
    both_sides(
        triangles_of(node), [&] { write(triangles, child[0], pair.box[0].bounds(), first, at + 1, tree); },
        [&] { write(triangles, child[1], pair.box[1].bounds(), first + left, at + 2 * left, tree); });
  }

  // Those of the candidates that gain, the best first.
  void find_moves(Stop& stop) {
    tbb::enumerable_thread_specific<std::vector<Move>> found;
    using Range = tbb::blocked_range<size_t>;
    tbb::parallel_for(Range(0, candidates_.size(), 4096), [&](const Range& range) {
      if (stop.now()) return;
      std::vector<Move>& own = found.local();
      for (size_t i = range.begin(); i < range.end(); ++i)
        if (const Move move = best_move(candidates_[i]); move.beside != kNone) own.push_back(move);
    });
    moves_.clear();
    for (const std::vector<Move>& some : found) moves_.insert(moves_.end(), some.begin(), some.end());
    tbb::parallel_sort(moves_, [](const Move& a, const Move& b) {
      return a.gain != b.gain ? a.gain > b.gain : a.subtree < b.subtree;
    });
  }

  // Climbs from the subtree to the root, and looks into what hangs there on the other side, as far as that can gain.
  Move best_move(uint32_t subtree) const {
    Move move{subtree};
    const Slot own = slots_[subtree];
    if (own.parent == kNone || own.parent == kRoot) return move;
    const Box box = box_of(subtree);
    const float area = box.half_area();
    // The subtree goes beside a child, or into it. Saved is counted by the boxes above that no longer hold the subtree,
    // less those that then do.
    const auto look = [&](uint32_t node, uint32_t side, float saved_above, bool beside = true) {
      const Box& child = pairs_[node].box[side];
      const float gain = saved_above - together(child, box).half_area();
      if (beside && gain > move.gain) move.beside = children_[node][side], move.gain = gain;
      return gain + child.half_area();
    };
    struct Todo {
      uint32_t node;
      float saved_in_it;
    } todo[kMostLooks + 2];
    uint32_t looks = 0, left = 0;
    const auto push = [&](uint32_t node, float saved_in_it) {  // without branches: they are hard to predict
      todo[left] = {node, saved_in_it};
      left += uint32_t{!is_leaf(node)} & uint32_t{saved_in_it - area > move.gain};
    };
    float saved = box_of(own.parent).half_area();
    Box without = pairs_[own.parent].box[1 - own.side];
    for (Slot at = own;; at = slots_[at.parent]) {
      const bool is_own = at.parent == own.parent;
      const uint32_t other = 1 - at.side;
      push(children_[at.parent][other], look(at.parent, other, saved, !is_own));
      ++looks;
      while (left > 0) {
        const auto [node, saved_in_it] = todo[--left];
        if (saved_in_it - area <= move.gain) continue;
        looks += 2;
        if (looks > kMostLooks) return move;
        const float in[] = {look(node, 0, saved_in_it), look(node, 1, saved_in_it)};
        const uint32_t better = in[1] > in[0];
        push(children_[node][1 - better], in[1 - better]), push(children_[node][better], in[better]);
      }
      if (at.parent == kRoot) return move;
      if (is_own) continue;
      without.add(pairs_[at.parent].box[other]);
      saved += box_of(at.parent).half_area() - without.half_area();
    }
  }

  // The subtree takes its parent along; its sibling goes where the parent was.
  void make(const Move& move) {
    const Slot own = slots_[move.subtree], left = slots_[own.parent];
    const uint32_t other = 1 - own.side;
    const Pair& parent = pairs_[own.parent];
    hang(children_[own.parent][other], left, parent.box[other]);
    const Slot entered = slots_[move.beside];
    hang(move.beside, {own.parent, other}, box_of(move.beside));
    hang(own.parent, entered, together(parent.box[0], parent.box[1]));
    refit(left.parent), refit(entered.parent);
  }
  void hang(uint32_t node, Slot slot, const Box& box) {
    slots_[node] = slot;
    children_[slot.parent][slot.side] = node, pairs_[slot.parent].box[slot.side] = box;
  }
  // The boxes of a node and of those above it, where they change.
  void refit(uint32_t node) {
    for (; node != kRoot; node = slots_[node].parent) {
      const Box box = together(pairs_[node].box[0], pairs_[node].box[1]);
      if (std::exchange(box_of(node), box) == box) return;
    }
  }

  Box& box_of(uint32_t node) const { return pairs_[slots_[node].parent].box[slots_[node].side]; }
  uint32_t sibling(uint32_t node) const { return children_[slots_[node].parent][1 - slots_[node].side]; }
  bool is_below(uint32_t node, uint32_t top) const {
    while (node != kNone && node != top) node = slots_[node].parent;
    return node == top;
  }

  // Of inner nodes, the root first: it never moves.
  size_t inner_count_;
  AlignedBytes memory_;
  Pair* pairs_;
  std::vector<std::array<uint32_t, 2>> children_;
  std::vector<uint32_t> triangles_;  // in each, once they are counted

  std::vector<Slot> slots_;  // of all nodes
  double areas_ = 0;         // of all boxes, as far as gains are as large as they looked

  // Of a round.
  struct Marks {
    bool touched = false, again = false;  // a candidate of the next one
  };
  std::vector<Marks> marks_;
  std::vector<uint32_t> candidates_;  // all; then those that could not move, and those beside which something changed
  std::vector<Move> moves_;
};

}  // namespace

void reinsert(BinaryTree& tree, Stop& stop) {
  if (tree.nodes.size() < 2 || stop.now()) return;
  for (uint32_t rounds = kMostRounds; rounds > 0; rounds /= 2) {
    Reinserter reinserter(tree);
    for (uint32_t round = 0; round < rounds && reinserter.improve(stop); ++round) {
    }
    if (stop.stopped()) return;
    if (reinserter.write(tree)) return;
  }
}

}  // namespace vcd::baker
