#include <vcd/format/tree_statistics.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <vector>

#include <xxhash.h>

namespace vcd {
namespace {

// One subtree: who it is, and what it adds to the totals each time it is reached.
struct Node {
  uint64_t identity = 0;  // equal subtrees of a level have equal identities; those of one class have its number
  uint64_t clear = 0, blocked = 0, statistical = 0;
  uint64_t unfolded = 1;
  uint64_t folded = 1;
  bool leaf() const { return identity < kClasses; }
};
struct Totals {
  uint64_t clear = 0, blocked = 0, statistical = 0, unfolded = 0, folded = 0;
};

// A block's identity from its index; blocks of one class have their class instead.
uint64_t identity_of_block(uint64_t index) { return index < kUniformBlocks ? index : index + kClasses; }

// Joins sixteen children into their parent; the caller gives the identity.
Node join(const Node* children, uint64_t identity) {
  Node parent{identity, 0, 0, 0, 1, 1};
  const bool all_leaves = std::all_of(children, children + 16, [](const Node& n) { return n.leaf(); });
  for (int i = 0; i < 16; ++i) {
    parent.clear += children[i].clear;
    parent.blocked += children[i].blocked;
    parent.statistical += children[i].statistical;
    if (identity < kClasses) continue;  // all descendants agree: the parent is a leaf, the children do not exist
    parent.unfolded += children[i].unfolded;
    if (!all_leaves) parent.folded += children[i].folded;
  }
  return parent;
}

bool is_group(const Node* children) {  // sixteen words of their own: neither a leaf's nor folded into one word
  return std::any_of(children, children + 16, [](const Node& n) { return !n.leaf(); });
}

// Tells groups of sixteen apart by the identities of their children.
class Groups {
 public:
  uint64_t identity_of(const Node* children) {
    const uint64_t first = children[0].identity;
    if (first < kClasses && std::all_of(children, children + 16, [&](const Node& n) { return n.identity == first; }))
      return first;
    uint64_t key[16];
    for (int i = 0; i < 16; ++i) key[i] = children[i].identity;
    const uint64_t hash = XXH3_64bits(key, sizeof key);
    if (is_group(children)) group_hashes_.push_back(hash);
    return hash | kClasses;  // never a class; equal children give equal identities
  }
  uint64_t distinct_groups() {
    std::sort(group_hashes_.begin(), group_hashes_.end());
    group_hashes_.erase(std::unique(group_hashes_.begin(), group_hashes_.end()), group_hashes_.end());
    return group_hashes_.size();
  }

 private:
  std::vector<uint64_t> group_hashes_;
};

struct BrickSummary {
  uint16_t clear, blocked, statistical;
  uint8_t mixed_groups;  // of the sixteen 2×2×2×2 groups of cells, those whose cells differ
};

// The children of cell group (s, t, u, v), each 0 or 1, in a row-major array with `bits` bits a coordinate.
void gather_children(uint32_t parent, uint32_t bits, uint32_t indices[16]) {
  const uint32_t mask = (1u << (bits - 1)) - 1, b = bits - 1;
  const uint32_t s = parent >> (3 * b) & mask, t = parent >> (2 * b) & mask, u = parent >> b & mask, v = parent & mask;
  for (uint32_t i = 0; i < 16; ++i)
    indices[i] = ((2 * s + (i >> 3)) << (3 * bits)) | ((2 * t + (i >> 2 & 1)) << (2 * bits)) |
                 ((2 * u + (i >> 1 & 1)) << bits) | (2 * v + (i & 1));
}

BrickSummary summarize_brick(const uint8_t* brick) {
  BrickSummary summary{};
  for (uint32_t group = 0; group < 16; ++group) {
    uint32_t cells[16], seen = 0;
    gather_children(group, 2, cells);
    for (uint32_t cell : cells) {
      const CellClass found = brick_cell(brick, cell);
      seen |= just(found);
      summary.clear += found == CellClass::clear;
      summary.blocked += found == CellClass::blocked;
      summary.statistical += found == CellClass::statistically_blocked;
    }
    summary.mixed_groups += (seen & (seen - 1)) != 0;
  }
  return summary;
}

Node brick_node(const BrickSummary& brick, uint32_t index) {
  const bool all_statistical = brick.statistical == 4 * kBrickBytes;
  if (index < kUniformBlocks || all_statistical)
    return {all_statistical ? 3 : index, brick.clear, brick.blocked, brick.statistical, 1, 1};
  return {identity_of_block(index),     brick.clear, brick.blocked, brick.statistical, 17u + 16u * brick.mixed_groups,
          brick.mixed_groups ? 17u : 1u};
}

// Reduces row-major levels of nodes, sixteen to one, down to one node. nodes has 16^levels entries.
Node reduce(std::vector<Node>& nodes, uint32_t levels, Groups* groups) {
  for (uint32_t bits = levels; bits > 0; --bits) {
    std::vector<Node> parents(size_t{1} << (4 * (bits - 1)));
    for (uint32_t p = 0; p < parents.size(); ++p) {
      uint32_t indices[16];
      Node children[16];
      gather_children(p, bits, indices);
      for (int i = 0; i < 16; ++i) children[i] = nodes[indices[i]];
      parents[p] = join(children, groups[bits - 1].identity_of(children));
    }
    nodes.swap(parents);
  }
  return nodes[0];
}

uint64_t count_unreferenced(const std::vector<bool>& referenced) {
  uint64_t count = 0;
  for (size_t i = kUniformBlocks; i < referenced.size(); ++i) count += !referenced[i];
  return count;
}

uint64_t count_duplicates(const void* pool, uint64_t count, size_t block_bytes) {
  std::vector<uint64_t> hashes(count);
  for (uint64_t i = 0; i < count; ++i)
    hashes[i] = XXH3_64bits(static_cast<const std::byte*>(pool) + i * block_bytes, block_bytes);
  std::sort(hashes.begin(), hashes.end());
  return count - static_cast<uint64_t>(std::unique(hashes.begin(), hashes.end()) - hashes.begin());
}

}  // namespace

TreeStatistics measure_tree(const TreeView& tree) {
  TreeStatistics result;
  uint64_t groups = 0;

  std::vector<BrickSummary> bricks(tree.brick_count);
  for (uint64_t i = 0; i < tree.brick_count; ++i) {
    bricks[i] = summarize_brick(tree.bricks + i * kBrickBytes);
    groups += i >= kUniformBlocks && bricks[i].mixed_groups > 0;
    result.mixed_groups += bricks[i].mixed_groups;
  }
  std::vector<bool> brick_seen(tree.brick_count);
  const auto node_of_brick = [&](uint32_t index) {
    assert(index < tree.brick_count);
    brick_seen[index] = true;
    return brick_node(bricks[index], index);
  };

  // Of the pool that the one above refers to: its nodes, and which of them are referred to. The bricks come first.
  const uint32_t levels = tree.shape.block_levels;
  std::vector<Node> nodes;
  std::vector<bool> seen;
  const auto node_below = [&](uint32_t level, uint32_t index) {
    if (level == levels) return node_of_brick(index);
    assert(index < nodes.size());
    seen[index] = true;
    return nodes[index];
  };
  for (uint32_t level = levels; level-- > 0;) {
    std::vector<Node> above(tree.block_counts[level]);
    Groups groups_here;
    for (uint32_t i = 0; i < above.size(); ++i) {
      Node children[16];
      for (int c = 0; c < 16; ++c) children[c] = node_below(level + 1, tree.blocks[level][size_t{i} * kBlockWords + c]);
      const uint64_t identity = groups_here.identity_of(children);
      above[i] = join(children, identity < kClasses ? identity : identity_of_block(i));
    }
    groups += groups_here.distinct_groups();
    result.unreferenced_blocks += count_unreferenced(seen);
    result.duplicate_blocks += count_duplicates(tree.blocks[level], above.size(), kBlockBytes);
    nodes.swap(above);
    seen.assign(nodes.size(), false);
  }

  Groups groups_top[3];
  Totals totals;
  const uint32_t words_a_pair = 1u << (4 * tree.shape.top_levels);
  for (uint32_t pair = 0; pair < kFacePairs; ++pair) {
    std::vector<Node> slots(words_a_pair);
    for (uint32_t w = 0; w < words_a_pair; ++w) slots[w] = node_below(0, tree.top[pair * words_a_pair + w]);
    const Node root = reduce(slots, tree.shape.top_levels, groups_top);
    totals.clear += root.clear;
    totals.blocked += root.blocked;
    totals.statistical += root.statistical;
    totals.unfolded += root.unfolded;
    totals.folded += root.folded;
  }

  for (Groups& level : groups_top) groups += level.distinct_groups();
  result.cells = {totals.clear, totals.blocked, tree.shape.cells() - totals.clear - totals.blocked - totals.statistical,
                  totals.statistical};
  result.nodes_unfolded = totals.unfolded;
  result.nodes_folded = totals.folded;
  result.nodes_shared = kFacePairs + 16 * groups;
  result.unreferenced_blocks += count_unreferenced(brick_seen) + count_unreferenced(seen);
  result.duplicate_blocks += count_duplicates(tree.bricks, tree.brick_count, kBrickBytes);
  return result;
}

}  // namespace vcd
