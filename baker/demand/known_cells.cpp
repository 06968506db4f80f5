#include "demand/known_cells.h"

#include <algorithm>

namespace vcd::baker {
namespace {

// The entries of a block, or of the top table, that lie below a cell: those whose bits from `level` on are the cell's.
// The block resolves `bits` levels from level `first`.
struct Part {
  uint32_t first, bits;

  // any(index) for each; true once it is.
  template <class Any>
  bool any(const Cell& cell, const Any& any) const {
    const uint32_t end = first + bits, fixed = std::min(cell.level, end) - first, open = bits - fixed;
    const uint32_t down = cell.level - first - fixed;
    for (uint32_t i = 0; i < 1u << (4 * open); ++i) {
      const auto part = [&](uint32_t x, uint32_t shift) {
        const uint32_t mask = (1u << fixed) - 1;
        return (x >> down & mask) << open | (i >> (shift * open) & ((1u << open) - 1));
      };
      const uint32_t index =
          ((part(cell.s, 3) << bits | part(cell.t, 2)) << bits | part(cell.u, 1)) << bits | part(cell.v, 0);
      if (any(index)) return true;
    }
    return false;
  }
};

}  // namespace

std::optional<uint32_t> KnownCells::all_of(const Cell& cell) const {
  const TreeView& tree = *known_;
  // The entry that stands for all below the cell; nothing where they differ, or where a block of several classes is
  // below. `index`: of the block that holds the cell.
  uint32_t level = 0, index = 0;
  const auto step = [&](const auto& entry, uint32_t bits) {
    std::optional<uint32_t> same;
    const bool differ = Part{level, bits}.any(cell, [&](uint32_t i) {
      const uint32_t value = entry(i);
      if (!same) same = value;
      return *same != value;
    });
    level += bits;
    return differ ? std::nullopt : same;
  };
  auto found =
      step([&](uint32_t i) { return tree.top[cell.pair << (4 * tree.shape.top_levels) | i]; }, tree.shape.top_levels);
  for (uint32_t k = 0; k < tree.shape.block_levels; ++k) {
    if (!found || *found < kUniformBlocks) return found;
    if (cell.level < level) return std::nullopt;
    index = *found;
    found = step([&](uint32_t i) { return tree.blocks[k][size_t{index} * kBlockWords + i]; }, 1);
  }
  if (!found || *found < kUniformBlocks) return found;
  if (cell.level < level) {  // above the bricks, all one brick: it may be blocked by statistics as a whole
    const uint8_t* brick = tree.bricks + size_t{*found} * kBrickBytes;
    const bool all = std::all_of(brick, brick + kBrickBytes, [](uint8_t b) { return b == 0xFF; });
    return all ? std::optional<uint32_t>(kStatisticallyBlocked) : std::nullopt;
  }
  index = *found;
  return step(
      [&](uint32_t i) { return static_cast<uint32_t>(brick_cell(tree.bricks + size_t{index} * kBrickBytes, i)); }, 2);
}

std::optional<uint32_t> KnownCells::in_divided_brick(const Cell& cell) const {
  if (cell.level != known_->shape.levels || all_of(cell.parent().parent())) return std::nullopt;
  const uint32_t up = 8 - cell.level;
  LineCell line{};
  line.pair = cell.pair, line.s = cell.s << up, line.t = cell.t << up, line.u = cell.u << up, line.v = cell.v << up;
  return static_cast<uint32_t>(class_of(*known_, line));
}

uint32_t KnownCells::classify(const Cell& cell, bool deepest, Workspace& workspace) const {
  if (known_ && cell.level <= known_->shape.levels) {
    const auto all = all_of(cell);
    if (all == kClear || all == kBlocked) return *all;
    if (!deepest && !all) return kDeeper;
    if (deepest)
      if (const auto value = in_divided_brick(cell)) return *value;
  }
  ++workspace.cells;
  return cells_.classify(cell, deepest, workspace);
}

const TreeView* usable_cells(const std::optional<KnownTree>& known, const BakeOptions& options, uint32_t samples) {
  if (!known || options.method == Method::sampled || known->record.method != static_cast<uint8_t>(options.method) ||
      known->record.depth <= kMinDepth)
    return nullptr;
  const auto& parameters = known->record.method_parameters;
  const bool same_statistics =
      parameters[0] == samples && (uint64_t{parameters[2]} << 32 | parameters[1]) == options.seed;
  return options.method == Method::proven || same_statistics ? &known->tree : nullptr;
}

}  // namespace vcd::baker
