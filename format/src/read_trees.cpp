// The trees: indices that stay inside, and, of canonical files, everything that can be counted.
#include <array>

#include <vcd/format/checksum.h>
#include <vcd/format/tree_statistics.h>

#include "reading.h"

namespace vcd {
namespace {

// The tree of objects of method none, which no file holds: all cells are unclassified.
struct alignas(64) UnclassifiedTree {
  static constexpr TreeShape kShape = tree_shape(kMinDepth);
  std::array<uint32_t, kShape.top_bytes() / 4> top{};
  std::array<uint8_t, kUniformBlocks * kBrickBytes> bricks{};

  constexpr UnclassifiedTree() {
    std::fill_n(top.begin(), kShape.top_words(), 2u);
    for (size_t i = 0; i < bricks.size(); ++i) bricks[i] = static_cast<uint8_t>(i / kBrickBytes * 0x55);
  }
};
constexpr UnclassifiedTree kUnclassifiedTree;

// Every word of every block is below `below`; blocks 0, 1, 2 are uniform.
bool check_pool(Reading& reading, const uint32_t* words, uint64_t count, uint64_t below, uint64_t at) {
  uint32_t largest = 0;
  for (uint64_t i = 0; i < count * kBlockWords; ++i) largest = std::max(largest, words[i]);
  if (count > 0 && largest >= below)
    return reading.report(FindingId::tree_index, at,
                          "index " + std::to_string(largest) + " of " + std::to_string(below));
  for (uint64_t i = 0; i < std::min<uint64_t>(count, kUniformBlocks) * kBlockWords; ++i)
    if (words[i] != i / kBlockWords) return reading.report(FindingId::tree_uniform, at);
  return true;
}

// Every index stays inside its pool, and what must be uniform is.
bool check_bounds(Reading& reading, const TreeView& tree, uint64_t at) {
  uint64_t below_top = tree.brick_count;
  bool good = true;
  for (uint32_t k = tree.shape.block_levels; k-- > 0 && good; below_top = tree.block_counts[k])
    good = check_pool(reading, tree.blocks[k], tree.block_counts[k], below_top, at);
  const uint64_t used = tree.shape.top_words();
  if (const uint32_t largest = *std::max_element(tree.top, tree.top + used); good && largest >= below_top)
    good =
        reading.report(FindingId::tree_index, at,
                       "index " + std::to_string(largest) + " of " + std::to_string(below_top) + " in the top table");
  if (!all_zero(std::span(tree.top + used, tree.shape.top_bytes() / 4 - used)))
    good = reading.report(FindingId::tree_spare, at, "after word " + std::to_string(used) + " of the top table");
  for (uint64_t i = 0; i < kUniformBlocks * kBrickBytes; ++i)
    if (tree.bricks[i] != i / kBrickBytes * 0x55) return reading.report(FindingId::tree_uniform, at, "bricks");
  return good;
}

bool check_canonical(Reading& reading, const TreeView& tree, const ObjectRecord& r, uint64_t tree_at,
                     uint64_t record_at) {
  const TreeStatistics s = measure_tree(tree);
  if (r.depth == 1 && s.mixed_groups > 0)
    return reading.report(FindingId::tree_depth, tree_at,
                          std::to_string(s.mixed_groups) + " groups of sixteen cells differ");
  if (s.cells[3] > 0 && r.method != static_cast<uint8_t>(Method::hybrid))
    return reading.report(FindingId::tree_class, tree_at, std::to_string(s.cells[3]) + " cells of class 3");
  if (s.unreferenced_blocks > 0)
    return reading.report(FindingId::tree_unreferenced, tree_at, std::to_string(s.unreferenced_blocks) + " blocks");
  if (s.duplicate_blocks > 0)
    return reading.report(FindingId::tree_duplicate, tree_at, std::to_string(s.duplicate_blocks) + " blocks");
  return (s.cells == std::array{r.cells[0], r.cells[1], r.cells[2], r.statistical_cells} &&
          s.nodes_unfolded == r.nodes_unfolded && s.nodes_folded == r.nodes_folded &&
          s.nodes_shared == r.nodes_shared) ||
         reading.report(FindingId::object_statistics, record_at);
}

bool read_tree(Reading& reading, uint32_t index) {
  ObjectContents& object = reading.contents.objects[index];
  const ObjectRecord& r = *object.record;
  const bool is_stored = r.method != static_cast<uint8_t>(Method::none);
  const uint64_t at = is_stored ? reading.contents.sections[r.tree_section].offset : reading.record_offset(index);

  TreeView& tree = object.tree;
  tree.shape = tree_shape(r.depth);
  tree.block_counts = r.block_counts;
  tree.brick_count = r.brick_count;
  tree.answers =
      answer_table(r.method == static_cast<uint8_t>(Method::hybrid) ? Trust::statistics : Trust::proofs, classes_in(r));
  if (is_stored) {
    const Bytes bytes =
        mapped_bytes(reading, reading.contents.sections[r.tree_section], "object " + std::to_string(index));
    if (bytes.empty()) return false;  // no tree is of no bytes
    tree.top = reinterpret_cast<const uint32_t*>(bytes.data());
    const uint32_t* next = tree.top + tree.shape.top_bytes() / 4;
    for (uint32_t k = 0; k < tree.shape.block_levels; next += size_t{tree.block_counts[k++]} * kBlockWords)
      tree.blocks[k] = next;
    tree.bricks = reinterpret_cast<const uint8_t*>(next);
    if (!check_bounds(reading, tree, at)) return false;
  } else {
    tree.top = kUnclassifiedTree.top.data();
    tree.bricks = kUnclassifiedTree.bricks.data();
  }
  return !reading.canonical() || check_canonical(reading, tree, r, at, reading.record_offset(index));
}

}  // namespace

bool read_trees(Reading& reading) {
  for (uint32_t i = 0; i < reading.contents.objects.size(); ++i)
    if (!read_tree(reading, i)) return false;
  return true;
}

}  // namespace vcd
