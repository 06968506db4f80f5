#include "octree/demote.h"

#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include <vcd/format/tree_statistics.h>

#include "classify/make_classifier.h"
#include "classify/sampled_cells.h"
#include "measure/thinned_cells.h"
#include "octree/octree.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/trees.h"

namespace vcd::test {
using namespace baker;
namespace {

double classified(const TreeView& tree) {
  const TreeStatistics s = measure_tree(tree);
  return 1 - static_cast<double>(s.cells[2]) / static_cast<double>(tree.shape.cells());
}

// Every cell of both trees: each pair of bricks that stand at the same place, once.
void expect_weaker_everywhere(const TreeView& before, const TreeView& after) {
  std::set<std::tuple<uint32_t, uint32_t, uint32_t>> seen;
  const auto compare = [&](uint32_t a, uint32_t b) {
    if (!seen.insert({0, a, b}).second) return;
    for (uint32_t c = 0; c < 256; ++c) {
      const CellClass was = brick_cell(before.bricks + size_t{a} * kBrickBytes, c),
                      is = brick_cell(after.bricks + size_t{b} * kBrickBytes, c);
      ASSERT_TRUE(is == was || is == CellClass::unclassified ||
                  (was == CellClass::blocked && is == CellClass::statistically_blocked));
    }
  };
  const auto compare_below = [&](const auto& self, uint32_t level, uint32_t a, uint32_t b) -> void {
    if (level == before.shape.block_levels) return compare(a, b);
    if (!seen.insert({1 + level, a, b}).second) return;
    for (size_t i = 0; i < kBlockWords; ++i)
      self(self, level + 1, before.blocks[level][a * kBlockWords + i], after.blocks[level][b * kBlockWords + i]);
  };
  for (uint32_t slot = 0; slot < before.shape.top_words(); ++slot)
    compare_below(compare_below, 0, before.top[slot], after.top[slot]);
}

// The tree as DagBuilder makes it when it is given all its bricks again.
TreeArrays rebuilt(const TreeArrays& tree) {
  const TreeShape shape = tree.shape;
  DagBuilder builder(tree.depth);
  for (uint32_t slot = 0; slot < shape.top_words(); ++slot) {
    Subtree subtree;
    const auto add = [&](uint32_t index) {
      if (index < kUniformBlocks) return subtree.bricks.push_back(index);
      subtree.bricks.push_back(kDeeper + static_cast<uint32_t>(subtree.words.size()));
      std::copy_n(&tree.bricks[size_t{index} * 16], 16, subtree.words.emplace_back().begin());
    };
    const auto add_below = [&](const auto& self, uint32_t level, uint32_t index) -> void {
      if (level == shape.block_levels) return add(index);
      for (size_t i = 0; i < kBlockWords; ++i) self(self, level + 1, tree.blocks[level][index * kBlockWords + i]);
    };
    add_below(add_below, 0, tree.top[slot]);
    builder.append(subtree);
  }
  return builder.take();
}

void expect_equal(const TreeArrays& a, const TreeArrays& b) {
  EXPECT_TRUE(a.top == b.top && a.blocks == b.blocks && a.bricks == b.bricks);
}

// No block twice or unused, and all in the order in which the top table reaches them.
void expect_sound(const TreeArrays& tree) {
  const TreeStatistics s = measure_tree(tree.view());
  EXPECT_EQ(s.unreferenced_blocks, 0u);
  EXPECT_EQ(s.duplicate_blocks, 0u);
  expect_equal(tree, rebuilt(tree));
}

// The classified share when the poorest bricks become unclassified until the tree fits.
double pruned(const TreeView& tree, uint32_t depth, uint64_t budget) {
  std::vector<std::pair<uint32_t, uint32_t>> by_worth;
  for (uint32_t i = kUniformBlocks; i < tree.brick_count; ++i) {
    uint32_t cells = 0;
    for (uint32_t c = 0; c < 256; ++c)
      cells += brick_cell(tree.bricks + size_t{i} * kBrickBytes, c) != CellClass::unclassified;
    by_worth.push_back({cells, i});
  }
  std::sort(by_worth.begin(), by_worth.end());
  const auto without = [&](size_t count) {
    TreeArrays copy = arrays_of(tree, depth);
    for (size_t k = 0; k < count; ++k) std::fill_n(&copy.bricks[size_t{by_worth[k].second} * 16], 16, 0xAAAAAAAAu);
    return rebuilt(copy);
  };
  size_t too_few = 0, enough = by_worth.size();
  while (enough - too_few > std::max<size_t>(by_worth.size() / 200, 1)) {
    const size_t middle = (too_few + enough) / 2;
    (without(middle).view().bytes() <= budget ? enough : too_few) = middle;
  }
  return classified(without(too_few).view());  // a little over the budget: too good, if anything
}

// Of a deep tree a part, so that it is soon baked: what is below one in so many cells of the top table.
TreeArrays part_of_tree(SourceMesh source, uint32_t depth, uint32_t one_in) {
  const PreparedMesh mesh = *prepare(std::move(source));
  const GridMesh grid(mesh);
  const auto tracer = trace_in_grid(grid);
  const SampledCells all(SampledClassifier(*tracer, 16, 0));
  const ThinnedCells some(all, depth, one_in);
  return std::move(build_octree({some, depth}, 0, [](uint64_t, uint64_t, uint64_t) {})->tree);
}

// lost: the share of the classified cells below mixed top cells that may be lost.
void expect_better_than_pruning(const TreeArrays& tree, uint64_t divisor, double lost) {
  const TreeView before = tree.view();
  const uint32_t depth = tree.depth;
  const double had = classified(before), mixed = had - classified(demote_merge(tree, 0).tree.view());
  const uint64_t budget = before.shape.top_bytes() + (before.bytes() - before.shape.top_bytes()) / divisor;
  const auto [after, cells_lost] = demote_merge(tree, budget, 2);
  EXPECT_LE(after.view().bytes(), budget);
  EXPECT_GT(after.view().bytes(), budget * 98 / 100);
  expect_weaker_everywhere(before, after.view());
  expect_sound(after);
  EXPECT_EQ(cells_lost, measure_tree(after.view()).cells[2] - measure_tree(before).cells[2]);
  EXPECT_LT(had - classified(after.view()), (had - pruned(before, depth, budget)) / 2) << depth << ", " << divisor;
  EXPECT_LT(had - classified(after.view()), lost * mixed) << depth << ", " << divisor;
}

// No, one and two levels of blocks. Of deep trees some top cells, so that they are soon baked.
TEST(DemoteMerge, KeepsTheBudgetAndIsSafeAndBetterThanPruning) {
  if (kSanitized) GTEST_SKIP() << kOnceIsEnough;
  const TreeArrays shallow = arrays_of(must_bake(sphere(), proven(5)).tree(), 5);
  for (const auto& [divisor, lost] : {std::pair{2, 0.025}, {4, 0.065}, {8, 0.12}})
    expect_better_than_pruning(shallow, divisor, lost);
  const TreeArrays deep = part_of_tree(sphere(), 6, 8);
  for (const auto& [divisor, lost] : {std::pair{2, 0.03}, {4, 0.08}, {8, 0.18}})
    expect_better_than_pruning(deep, divisor, lost);
  const TreeArrays deeper = part_of_tree(sphere(), 7, 64);
  for (const auto& [divisor, lost] : {std::pair{2, 0.015}, {4, 0.065}})
    expect_better_than_pruning(deeper, divisor, lost);
}

TEST(DemoteMerge, LeavesWhatFitsAlone) {
  const BakedObject baked = must_bake(leaves(20), proven(4));
  const TreeArrays before = arrays_of(baked.tree(), 4);
  const Demoted after = demote_merge(before, baked.tree().bytes(), 1);
  expect_equal(after.tree, before);
  EXPECT_EQ(after.cells_lost, 0u);
}

TEST(DemoteMerge, GivesTheSameForAnyNumberOfThreads) {
  for (uint32_t depth : {5u, 6u, 7u}) {
    const TreeArrays before = part_of_tree(leaves(60), depth, depth == 5 ? 1 : 64);
    const uint64_t budget = before.shape.top_bytes() + (before.view().bytes() - before.shape.top_bytes()) / 5;
    const TreeArrays one = demote_merge(before, budget, 1).tree;
    for (unsigned threads : {2u, 7u, 0u}) expect_equal(demote_merge(before, budget, threads).tree, one);
  }
}

// The golden trees of all depths, with all four classes.
TEST(DemoteMerge, KnowsEveryLayoutAndClass) {
  for (uint32_t depth = 2; depth <= 8; ++depth) {
    std::vector<Finding> findings;
    const auto file = read_file(std::filesystem::path(VCD_GOLDEN_DIR) / ("depth" + std::to_string(depth) + ".vcd"));
    const auto contents = read_sidecar(file, CheckLevel::canonical, findings);
    ASSERT_TRUE(contents.has_value());
    const TreeView before = contents->objects[0].tree;
    const uint64_t smallest = before.shape.least_bytes();
    for (uint64_t spare : {0, 64, 1000, 3000, 20000}) {
      if (kSanitized && depth > 5 && spare != 1000) continue;
      const TreeArrays after = demote_merge(arrays_of(before, depth), smallest + spare).tree;
      EXPECT_LE(after.view().bytes(), smallest + spare) << depth;
      expect_weaker_everywhere(before, after.view());
      expect_sound(after);
    }
    EXPECT_EQ(demote_merge(arrays_of(before, depth), 10).tree.view().bytes(), smallest);  // nothing fits
  }
}

// Two bricks that differ in every combination of classes become the one that is right for both.
TEST(DemoteMerge, JoinsEveryPairOfClasses) {
  constexpr uint32_t common[4][4] = {{0, 2, 2, 2}, {2, 1, 2, 3}, {2, 2, 2, 2}, {2, 3, 2, 3}};
  BrickWords a{}, b{}, expected{};
  for (uint32_t i = 0; i < 256; ++i) {
    const uint32_t x = i < 200 ? i % 2 : i % 4, y = i < 200 ? x : i / 4 % 4;  // alike for the most part
    a[i / 16] |= x << (2 * (i % 16));
    b[i / 16] |= y << (2 * (i % 16));
    expected[i / 16] |= common[x][y] << (2 * (i % 16));
  }
  DagBuilder builder(2);
  for (uint32_t slot = 0; slot < kFacePairs; ++slot) builder.append({{kDeeper}, {slot % 2 ? a : b}});
  TreeArrays tree = builder.take();
  const TreeArrays after = demote_merge(tree, tree.view().bytes() - kBrickBytes).tree;
  ASSERT_EQ(after.bricks.size(), 16 * (kUniformBlocks + 1));
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), after.bricks.begin() + 16 * kUniformBlocks));
}

}  // namespace
}  // namespace vcd::test
