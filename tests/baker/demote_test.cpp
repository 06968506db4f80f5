#include "octree/demote.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <vcd/format/tree_statistics.h>

#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
namespace {

TreeArrays arrays_of(const TreeView& tree, uint32_t depth) {
  const auto words = [](const void* from, uint64_t bytes) {
    std::vector<uint32_t> copy(bytes / 4);
    if (bytes) std::memcpy(copy.data(), from, bytes);
    return copy;
  };
  return {depth, tree.shape, words(tree.top, tree.shape.top_bytes()), words(tree.blocks256, tree.block256_count * kBlock256Words * 4),
          words(tree.blocks16, tree.block16_count * kBlock16Words * 4), words(tree.bricks, tree.brick_count * kBrickBytes)};
}

uint64_t bytes_of(const TreeView& tree) { return tree.shape.bytes(tree.block256_count, tree.block16_count, tree.brick_count); }

double classified(const TreeView& tree) {
  const TreeStatistics s = measure_tree(tree);
  return 1 - static_cast<double>(s.cells[2]) / static_cast<double>(tree.shape.cells());
}

// Random cells of a deep tree, all of a shallow one.
void expect_weaker_everywhere(const TreeView& before, const TreeView& after, uint32_t count) {
  std::mt19937 random(count);
  for (uint32_t i = 0; i < count; ++i) {
    LineCell line{};
    const uint32_t bits = random();
    line.pair = random() % kFacePairs, line.s = bits & 255, line.t = bits >> 8 & 255, line.u = bits >> 16 & 255, line.v = bits >> 24;
    const uint32_t was = bits_from_slot(before, before.shape, top_slot(before.shape, line), line);
    const uint32_t is = bits_from_slot(after, after.shape, top_slot(after.shape, line), line);
    ASSERT_TRUE(is == was || is == 2 || (was == 1 && is == 3)) << was << " became " << is;
  }
}

void expect_sound(const TreeArrays& tree) {
  const TreeStatistics s = measure_tree(tree.view());
  EXPECT_EQ(s.unreferenced_blocks, 0u);
  EXPECT_EQ(s.duplicate_blocks, 0u);
}

// What is left of a brick's value when the poorest bricks become unclassified until the tree fits.
double pruned(const TreeView& tree, uint64_t budget) {
  std::vector<std::pair<uint32_t, uint32_t>> by_worth;
  for (uint32_t i = kUniformBlocks; i < tree.brick_count; ++i) {
    uint32_t cells = 0;
    for (uint32_t c = 0; c < 256; ++c) cells += brick_cell(tree.bricks + size_t{i} * kBrickBytes, c) != 2;
    by_worth.push_back({cells, i});
  }
  std::sort(by_worth.begin(), by_worth.end());
  TreeArrays copy = arrays_of(tree, 5);
  const uint64_t drop = (bytes_of(tree) - budget + kBrickBytes - 1) / kBrickBytes;
  for (uint64_t k = 0; k < drop; ++k) std::fill_n(&copy.bricks[by_worth[k].second * 16], 16, 0xAAAAAAAAu);
  return classified(copy.view());
}

TEST(DemoteMerge, KeepsTheBudgetAndIsSafeAndBetterThanPruning) {
  const BakedObject baked = must_bake(sphere(), proven(5));
  const TreeView before = baked.tree();
  for (uint64_t divisor : {2, 4, 8}) {
    const uint64_t budget = before.shape.top_bytes() + (bytes_of(before) - before.shape.top_bytes()) / divisor;
    const TreeArrays after = demote_merge(arrays_of(before, 5), budget);
    EXPECT_LE(bytes_of(after.view()), budget);
    EXPECT_GT(bytes_of(after.view()), budget * 9 / 10);
    expect_weaker_everywhere(before, after.view(), 300000);
    expect_sound(after);
    EXPECT_GT(classified(after.view()), pruned(before, budget)) << divisor;
    EXPECT_GT(classified(after.view()), classified(before) - 0.02 * static_cast<double>(divisor)) << divisor;
  }
}

TEST(DemoteMerge, LeavesWhatFitsAlone) {
  const BakedObject baked = must_bake(leaves(20), proven(4));
  const TreeArrays before = arrays_of(baked.tree(), 4), after = demote_merge(before, bytes_of(baked.tree()));
  EXPECT_EQ(after.top, before.top);
  EXPECT_EQ(after.bricks, before.bricks);
}

TEST(DemoteMerge, GivesTheSameForAnyNumberOfThreads) {
  const BakedObject baked = must_bake(leaves(60), proven(5));
  const TreeArrays before = arrays_of(baked.tree(), 5);
  const uint64_t budget = (bytes_of(baked.tree()) + before.shape.top_bytes()) / 2;
  std::vector<TreeArrays> results;
  for (size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(demote_merge(before, budget));
  }
  for (const TreeArrays& result : results) {
    EXPECT_EQ(result.top, results[0].top);
    EXPECT_EQ(result.bricks, results[0].bricks);
  }
}

// The golden trees of all depths, with all four classes.
TEST(DemoteMerge, KnowsEveryLayoutAndClass) {
  for (uint32_t depth = 2; depth <= 8; ++depth) {
    std::vector<Finding> findings;
    const auto file = read_file(std::filesystem::path(VCD_GOLDEN_DIR) / ("v2-hybrid" + std::to_string(depth) + ".vcd"));
    const auto contents = read_sidecar(file, CheckLevel::full, findings);
    ASSERT_TRUE(contents.has_value());
    const TreeView before = contents->objects[0].tree;
    for (uint64_t spare : {0, 64, 1000, 3000, 20000}) {
      const uint64_t smallest = before.shape.bytes(before.shape.has_blocks256 ? 3 : 0, before.shape.has_blocks16 ? 3 : 0, 3);
      const TreeArrays after = demote_merge(arrays_of(before, depth), smallest + spare);
      EXPECT_LE(bytes_of(after.view()), smallest + spare) << depth;
      expect_weaker_everywhere(before, after.view(), 50000);
      expect_sound(after);
    }
    EXPECT_LE(bytes_of(demote_merge(arrays_of(before, depth), 10).view()), before.shape.bytes(3, 3, 3));  // nothing fits
  }
}

}  // namespace
}  // namespace vcd::test
