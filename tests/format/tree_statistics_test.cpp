#include <vcd/format/tree_statistics.h>

#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "octree/dag.h"
#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
using namespace baker;
namespace {

// The counts straight from the definition: every cell of the deepest level, asked one by one.
class Dense {
 public:
  explicit Dense(const TreeView& tree) : tree_(tree), levels_(tree.shape.levels), groups_(levels_) {
    for (uint32_t pair = 0; pair < kFacePairs; ++pair) visit(pair, 0, 0, 0, 0, 0);
  }
  TreeStatistics result() {
    statistics_.nodes_shared = kFacePairs;
    for (const auto& level : groups_) statistics_.nodes_shared += 16 * level.size();
    return statistics_;
  }

 private:
  struct Seen {
    std::string shape;  // "0" to "3" for a leaf, else the children in brackets
    bool leaf() const { return shape.size() == 1; }
  };

  Seen visit(uint32_t pair, uint32_t level, uint32_t s, uint32_t t, uint32_t u, uint32_t v) {
    if (level == levels_) {
      const uint32_t up = 8 - levels_;
      LineCell line{};
      line.pair = pair, line.s = s << up, line.t = t << up, line.u = u << up, line.v = v << up;
      const auto bits = static_cast<uint32_t>(class_of(tree_, line));
      ++statistics_.cells[bits];
      ++statistics_.nodes_unfolded;
      ++statistics_.nodes_folded;
      return {std::string(1, static_cast<char>('0' + bits))};
    }
    if (level == tree_.shape.top_levels) {  // a short cut past the billions of cells of wholly uniform top cells
      LineCell line{};
      const uint32_t up = 8 - level;
      line.pair = pair, line.s = s << up, line.t = t << up, line.u = u << up, line.v = v << up;
      if (const uint32_t index = tree_.top[top_slot(tree_.shape, line)]; index < kUniformBlocks) {
        statistics_.cells[index] += uint64_t{1} << (4 * (levels_ - level));
        ++statistics_.nodes_unfolded;
        ++statistics_.nodes_folded;
        return {std::string(1, static_cast<char>('0' + index))};
      }
    }
    const TreeStatistics before = statistics_;
    std::vector<Seen> children;
    for (uint32_t i = 0; i < 16; ++i)
      children.push_back(
          visit(pair, level + 1, 2 * s + (i >> 3), 2 * t + (i >> 2 & 1), 2 * u + (i >> 1 & 1), 2 * v + (i & 1)));
    std::string shape = "(";
    bool all_leaves = true, all_equal = true;
    for (const Seen& child : children) {
      shape += child.shape;
      all_leaves &= child.leaf();
      all_equal &= child.shape == children[0].shape;
    }
    if (all_leaves && all_equal) {
      statistics_.nodes_unfolded = before.nodes_unfolded + 1;
      statistics_.nodes_folded = before.nodes_folded + 1;
      return children[0];
    }
    ++statistics_.nodes_unfolded;
    statistics_.nodes_folded = all_leaves ? before.nodes_folded + 1 : statistics_.nodes_folded + 1;
    if (!all_leaves) groups_[level].insert(shape);
    return {shape + ")"};
  }

  const TreeView& tree_;
  uint32_t levels_;
  TreeStatistics statistics_;
  std::vector<std::set<std::string>> groups_;
};

TEST(TreeStatistics, EqualTheDefinitionAtEveryDepthThatCanBeCountedCellByCell) {
  for (uint32_t depth = 1; depth <= 4; ++depth)
    for (const SourceMesh& mesh : {cube(), sphere(6, 8), leaves(5)}) {
      const BakedObject object = must_bake(mesh, quick(depth));
      const TreeView tree = object.tree();
      TreeStatistics measured = measure_tree(tree);
      if (depth == 1) {
        EXPECT_EQ(measured.mixed_groups, 0u);
      }
      measured.mixed_groups = 0;
      EXPECT_EQ(measured, Dense(tree).result()) << mesh.name << " at depth " << depth;
    }
}

// A tree of random classes below a few top cells; all others are clear.
TreeArrays random_tree(uint32_t depth) {
  std::mt19937 random(depth);
  const TreeShape shape = tree_shape(depth);
  const uint32_t bricks = 1u << (4 * (shape.levels - 2 - shape.top_levels));
  DagBuilder builder(depth);
  for (uint32_t slot = 0; slot < shape.top_words(); ++slot) {
    Subtree subtree;
    subtree.bricks.assign(bricks, 0);
    if (slot % (shape.top_words() / 5) == 1) {
      if (slot > shape.top_words() / 2) random.seed(7);  // the last ones are all the same
      for (uint32_t& brick : subtree.bricks) {
        brick = static_cast<uint32_t>(random() % 5);
        if (brick < kUniformBlocks) continue;
        BrickWords words;
        for (uint32_t& word : words) {
          word = random() % 2 ? 0x55555555u : 0xAAAAAAAAu;  // whole rows of one class, so that some groups are leaves
          if (random() % 4 == 0) word ^= 0x3;
        }
        if (words[0] % 4 == 3 || random() % 3 == 0) words.fill(static_cast<uint32_t>(random() % 4) * 0x55555555u);
        brick = kDeeper + static_cast<uint32_t>(subtree.words.size());
        subtree.words.push_back(words);
      }
    }
    builder.append(subtree);
  }
  return builder.take();
}

TEST(TreeStatistics, EqualTheDefinitionOnEveryLayout) {
  for (uint32_t depth = 3; depth <= (kSanitized ? 6u : 8u); ++depth) {
    const TreeArrays arrays = random_tree(depth);
    const TreeView tree = arrays.view();
    TreeStatistics measured = measure_tree(tree);
    EXPECT_GT(measured.mixed_groups, 0u);
    measured.mixed_groups = 0;  // not in the definition below
    EXPECT_EQ(measured, Dense(tree).result()) << "depth " << depth;
    EXPECT_GT(measured.nodes_unfolded, measured.nodes_folded);
    if (depth >= 6) {
      EXPECT_GT(measured.nodes_folded, measured.nodes_shared);
    }
  }
}

}  // namespace
}  // namespace vcd::test
