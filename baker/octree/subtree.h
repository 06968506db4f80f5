// All that is below one cell of the top table, classified but not yet shared with anything.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include <vcd/baker/cell.h>
#include <vcd/baker/sampled.h>

namespace vcd {

using BrickWords = std::array<uint32_t, 16>;  // 256 cells × 2 bits

inline constexpr uint32_t kDeeper = 3;  // beside the classes 0, 1, 2: mixed, and not yet at the deepest level

// What the recursion asks at every cell.
struct CellSource {
  const SampledClassifier& classifier;
  uint32_t depth;
  std::function<bool()> stop = {};  // true: the rest need not be right, the tree will be thrown away

  // The class of a cell, or kDeeper. A mixed cell of the deepest level is unclassified. Adds the rays traced to `rays`.
  uint32_t classify(const Cell& cell, uint64_t& rays) const {
    const CellVerdict verdict = classifier.classify(cell, rays);
    if (verdict != CellVerdict::mixed) return static_cast<uint32_t>(verdict);
    return cell.level < depth ? kDeeper : 2u;
  }
};

// The bricks below one cell of the top table, in the order in which its blocks hold them.
struct Subtree {
  std::vector<uint32_t> bricks;   // 1, 16, 256 or 4096: a class (the whole brick has it), or 3 + index into `words`
  std::vector<BrickWords> words;
  uint64_t rays = 0;
};

// value: the class of the top cell where an ancestor or the cell itself decided it, else kDeeper.
Subtree classify_subtree(const CellSource& source, const Cell& top, uint32_t value);

}  // namespace vcd
