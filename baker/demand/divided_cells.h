// The cells that are divided because a demand asks for them, and the classes of what they are divided into.
#pragma once

#include <cassert>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <vcd/baker/cell.h>
#include <vcd/format/tree.h>

#include "classify/cell_classifier.h"

namespace vcd::baker {

// Cells of level `from` are divided into those of level `to` by one block or brick of the tree, of kBlockBytes.
struct Step {
  uint32_t from, to;

  uint32_t children() const { return 1u << (4 * (to - from)); }
  // Where a cell of level `to` stands in its block.
  uint32_t index(const Cell& c) const { return row_major(c.s, c.t, c.u, c.v, 0, to - from); }
  // The cell below `divided` that stands there.
  Cell cell(const Cell& divided, uint32_t index) const {
    const uint32_t bits = to - from, mask = (1u << bits) - 1;
    const auto below = [&](uint32_t x, uint32_t part) { return x << bits | (index >> (part * bits) & mask); };
    return {divided.pair, to, below(divided.s, 3), below(divided.t, 2), below(divided.u, 1), below(divided.v, 0)};
  }
};

// From the top table down; the last one is that of the bricks. depth: 2 to 8.
inline std::vector<Step> steps_of(uint32_t depth) {
  assert(depth >= 2 && depth <= kMaxDepth);
  const TreeShape shape = tree_shape(depth);
  std::vector<Step> steps;
  const uint32_t brick_level = shape.levels - 2;
  for (uint32_t level = shape.top_levels; level < brick_level; ++level) steps.push_back({level, level + 1});
  steps.push_back({brick_level, shape.levels});
  return steps;
}

// One number for each cell of every level.
inline uint64_t cell_key(const Cell& c) {
  return uint64_t{c.level} << 36 | uint64_t{c.pair} << 32 | c.s << 24 | c.t << 16 | c.u << 8 | c.v;
}

class DividedCells {
 public:
  explicit DividedCells(uint32_t depth) : steps_(steps_of(depth)) {}

  const std::vector<Step>& steps() const { return steps_; }
  uint32_t top_level() const { return steps_.front().from; }
  // The step that makes cells of this level, which is below the top table's.
  const Step& step_to(uint32_t level) const {
    size_t i = 0;
    while (steps_[i].to < level) ++i;
    return steps_[i];
  }

  // classes: of its cells of level step.to, by Step::index(); kDeeper where nothing is decided and nothing is asked;
  // where lines are asked of an undecided cell, kAsked and the class that it has if it is not divided.
  void divide(const Cell& cell, const std::vector<uint8_t>& classes) {
    first_.emplace(cell_key(cell), classes_.size());
    classes_.insert(classes_.end(), classes.begin(), classes.end());
  }
  static constexpr uint8_t kAsked = kDeeper + 1;

  // The classes that the cells of the top table have where they are not divided, in the table's order.
  std::vector<uint8_t> top;
  // each(cell), in that order.
  template <class Each>
  void for_top(const Each& each) const {
    const uint32_t bits = top_level(), mask = (1u << bits) - 1;
    for (uint32_t i = 0; i < kFacePairs << (4 * bits); ++i)
      each(Cell{i >> (4 * bits), bits, i >> (3 * bits) & mask, i >> (2 * bits) & mask, i >> bits & mask, i & mask});
  }
  uint8_t class_on_top(const Cell& c) const {
    const uint32_t bits = top_level();
    return top[c.pair << (4 * bits) | row_major(c.s, c.t, c.u, c.v, 0, bits)];
  }

  const uint8_t* classes_below(const Cell& cell) const {  // null: it is not divided
    const auto found = first_.find(cell_key(cell));
    return found == first_.end() ? nullptr : &classes_[found->second];
  }

 private:
  std::vector<Step> steps_;
  std::unordered_map<uint64_t, size_t> first_;
  std::vector<uint8_t> classes_;
};

// What the recursion over the octree asks where a demand has divided cells: these as deep as they are, everything else
// as coarse as the top table. All is known beforehand.
class CellsAsDivided : public CellClassifier {
 public:
  explicit CellsAsDivided(const DividedCells& divided) : divided_(divided) {}  // outlives this

  uint32_t classify(const Cell& cell, bool, Workspace&) const override {
    const uint32_t top = divided_.top_level();
    if (cell.level < top) return kDeeper;
    if (cell.level == top) return divided_.classes_below(cell) ? kDeeper : divided_.class_on_top(cell);
    const Step& step = divided_.step_to(cell.level);
    if (cell.level < step.to) return kDeeper;
    Cell above = cell;
    while (above.level > step.from) above = above.parent();
    const uint8_t value = divided_.classes_below(above)[step.index(cell)];
    if (value < kDeeper) return value;
    if (divided_.classes_below(cell)) return kDeeper;
    return value == kDeeper ? kUnclassified : value - uint32_t{DividedCells::kAsked};
  }

 private:
  const DividedCells& divided_;
};

}  // namespace vcd::baker
