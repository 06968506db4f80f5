// A part of a bake that stands for the whole.
#pragma once

#include <atomic>
#include <cassert>
#include <chrono>

#include <vcd/format/tree.h>

#include "classify/cell_classifier.h"
#include "classify/random.h"

namespace vcd::baker {

// Asks another classifier, but leaves all cells of the top table unclassified except one in so many, chosen by a hash.
class ThinnedCells : public CellClassifier {
 public:
  // all outlives this. depth: of the octree.
  ThinnedCells(const CellClassifier& all, uint32_t depth, uint32_t one_in)
      : all_(all), top_level_(tree_shape(depth).top_levels), one_in_(one_in) {
    assert(one_in > 0);
  }

  uint32_t classify(const Cell& cell, bool deepest, Workspace& workspace) const override {
    if (cell.level == top_level_) {
      if (!top_reached_.exchange(true)) top_reached_at_ = std::chrono::steady_clock::now();
      const uint32_t slot = cell.pair << (4 * top_level_) | row_major(cell.s, cell.t, cell.u, cell.v, 0, top_level_);
      if (mix_bits(slot) % one_in_ != 0) return kUnclassified;
    }
    return all_.classify(cell, deepest, workspace);
  }

  // When the first cell of the top table was asked: those above come before all of them. After the octree is built.
  std::chrono::steady_clock::time_point top_reached_at() const { return top_reached_at_; }

 private:
  const CellClassifier& all_;
  uint32_t top_level_, one_in_;
  mutable std::atomic<bool> top_reached_ = false;
  mutable std::chrono::steady_clock::time_point top_reached_at_ = std::chrono::steady_clock::now();
};

}  // namespace vcd::baker
