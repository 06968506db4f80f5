#include "demand/asked_cells.h"

#include <algorithm>

#include <tbb/parallel_for.h>

#include <vcd/format/tree.h>

#include "demand/divided_cells.h"

namespace vcd::baker {

std::vector<Asked> undecided_cells(const CellClassifier& classifier, const std::vector<AskedLine>& lines,
                                   uint32_t level, Workspaces& workspaces, const std::function<bool()>& over) {
  std::vector<Asked> cells;
  for (size_t i = 0; i < lines.size(); i = cells.back().end) {
    const auto pair = static_cast<uint32_t>(lines[i].key >> (4 * kKeyLevels));
    cells.push_back(asked_cell(lines, {pair, 0, 0, 0, 0, 0}, i, lines.size()));
  }
  for (;;) {
    std::vector<uint8_t> deeper(cells.size());
    tbb::parallel_for(size_t{0}, cells.size(), [&](size_t i) {
      deeper[i] = !over() && classifier.classify(cells[i].cell, false, workspaces.local()) == kDeeper;
    });
    std::vector<Asked> undecided;
    for (size_t i = 0; i < cells.size(); ++i)
      if (deeper[i]) undecided.push_back(cells[i]);
    if (undecided.empty() || undecided[0].cell.level == level) return undecided;
    cells.clear();
    for (const Asked& cell : undecided) for_children(lines, cell, [&](const Asked& child) { cells.push_back(child); });
  }
}

namespace {

constexpr size_t kLooks = 1024;  // cells that stand for all of a level

// How many cells of a level below these are asked and undecided: counted at the level of `cells` itself, else from some
// of them, evenly.
double count_undecided(const CellClassifier& classifier, const std::vector<AskedLine>& lines,
                       const std::vector<Asked>& cells, uint32_t level, Workspaces& workspaces) {
  if (cells.empty() || cells[0].cell.level == level) return static_cast<double>(cells.size());
  std::vector<Cell> below;
  const auto collect = [&](const auto& self, const Asked& asked) -> void {
    if (asked.cell.level == level) return below.push_back(asked.cell);
    for_children(lines, asked, [&](const Asked& child) { self(self, child); });
  };
  for (const Asked& cell : cells) collect(collect, cell);
  const size_t step = below.size() / kLooks + 1, looks = (below.size() + step - 1) / step;
  std::vector<uint8_t> deeper(looks);
  tbb::parallel_for(size_t{0}, looks, [&](size_t i) {
    deeper[i] = classifier.classify(below[i * step], false, workspaces.local()) == kDeeper;
  });
  const auto undecided = static_cast<double>(std::ranges::count(deeper, uint8_t{1}));
  return undecided / static_cast<double>(looks) * static_cast<double>(below.size());
}

}  // namespace

uint32_t pick_depth(const CellClassifier& classifier, const std::vector<AskedLine>& lines, uint64_t budget_bytes,
                    const std::function<bool()>& over) {
  const uint32_t top_level = tree_shape(kMaxDepth).top_levels;  // of all depths that have inner blocks
  Workspaces workspaces;
  const std::vector<Asked> cells = undecided_cells(classifier, lines, top_level, workspaces, over);
  const auto bytes_above_bricks = [&](uint32_t depth) {
    auto bytes = static_cast<double>(tree_shape(depth).top_bytes());
    const std::vector<Step> steps = steps_of(depth);
    for (size_t i = 0; i + 1 < steps.size(); ++i)
      bytes += count_undecided(classifier, lines, cells, steps[i].from, workspaces) * steps[i].block_bytes;
    return bytes;
  };
  uint32_t depth = kMaxDepth;
  while (depth > 2 && bytes_above_bricks(depth) > static_cast<double>(budget_bytes) / 2) --depth;
  return depth;
}

}  // namespace vcd::baker
