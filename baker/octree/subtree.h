// All that is below one cell of the top table, classified but not yet shared with anything.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <vcd/baker/cell.h>
#include <vcd/format/tree.h>

#include "classify/cell_classifier.h"

namespace vcd::baker {

using BrickWords = std::array<uint32_t, 16>;  // 256 cells × 2 bits

// What the recursion asks, and how deep it goes.
struct CellSource {
  const CellClassifier& classifier;
  uint32_t depth;
  // Once it is over, what is not classified yet is unclassified.
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::function<bool()> stop = {};  // true: the rest need not be right, the tree will be thrown away

  uint32_t classify(const Cell& cell, Workspace& workspace) const {
    if (deadline != deadline.max() && std::chrono::steady_clock::now() > deadline) return kUnclassified;
    return classifier.classify(cell, cell.level == depth, workspace);
  }
};

// How many bricks stand below one cell of the top table: 1, 16, 256 or 4096.
constexpr size_t bricks_below_top(const TreeShape& shape) {
  return size_t{1} << (4 * (shape.levels - 2 - shape.top_levels));
}

// The bricks below one cell of the top table, in the order in which its blocks hold them.
struct Subtree {
  // bricks_below_top() of them: a class (the whole brick has it), or kDeeper + index into `words`.
  std::vector<uint32_t> bricks;
  std::vector<BrickWords> words;
  std::optional<uint32_t> all = {};  // the class of everything, below kUniformBlocks; then there are no bricks
};

// value: the class of the top cell where an ancestor or the cell itself decided it, else kDeeper.
Subtree classify_subtree(const CellSource& source, const Cell& top, uint32_t value, Workspace& workspace);

}  // namespace vcd::baker
