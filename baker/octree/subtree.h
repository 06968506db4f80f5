// All that is below one cell of the top table, classified but not yet shared with anything.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

#include <vcd/baker/cell.h>

#include "classify/cell_classifier.h"

namespace vcd {

using BrickWords = std::array<uint32_t, 16>;  // 256 cells × 2 bits

// What the recursion asks, and how deep it goes.
struct CellSource {
  const CellClassifier& classifier;
  uint32_t depth;
  uint32_t one_in = 1;  // of so many top cells is classified, chosen by a hash; the others are unclassified
  // Once it is over, what is not classified yet is unclassified.
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::function<bool()> stop = {};  // true: the rest need not be right, the tree will be thrown away

  uint32_t classify(const Cell& cell, Workspace& workspace) const {
    if (deadline != deadline.max() && std::chrono::steady_clock::now() > deadline) return kUnclassified;
    return classifier.classify(cell, cell.level == depth, workspace);
  }
};

// The bricks below one cell of the top table, in the order in which its blocks hold them.
struct Subtree {
  // 1, 16, 256 or 4096: a class (the whole brick has it), or kDeeper + index into `words`.
  std::vector<uint32_t> bricks;
  std::vector<BrickWords> words;
};

// value: the class of the top cell where an ancestor or the cell itself decided it, else kDeeper.
Subtree classify_subtree(const CellSource& source, const Cell& top, uint32_t value, Workspace& workspace);

}  // namespace vcd
