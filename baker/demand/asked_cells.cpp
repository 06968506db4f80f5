#include "demand/asked_cells.h"

#include <algorithm>
#include <numeric>

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

// What a brick leaves of the weight that it is divided for, about: a third on Killeroo, four fifths on the
// Sierpinski pyramid.
constexpr double kLeftByBrick = 0.35;
// What a level more must be expected to answer of all that is asked: look-ups take longer in a deeper tree, and so does
// the bake.
constexpr double kWorthALevel = 0.04;

// The cells of a level that are asked, below these, and how many of them are undecided: by a look at some, evenly.
struct Level {
  std::vector<Asked> cells;
  double undecided = 1;  // share of them

  double count() const { return undecided * static_cast<double>(cells.size()); }
};

Level look_at(const CellClassifier& classifier, const std::vector<AskedLine>& lines, const std::vector<Asked>& above,
              uint32_t level, Workspaces& workspaces) {
  if (above.empty() || above[0].cell.level == level) return {above};
  Level result;
  const auto collect = [&](const auto& self, const Asked& asked) -> void {
    if (asked.cell.level == level) return result.cells.push_back(asked);
    for_children(lines, asked, [&](const Asked& child) { self(self, child); });
  };
  for (const Asked& cell : above) collect(collect, cell);
  const size_t step = result.cells.size() / kLooks + 1, looks = (result.cells.size() + step - 1) / step;
  std::vector<uint8_t> deeper(looks);
  tbb::parallel_for(size_t{0}, looks, [&](size_t i) {
    deeper[i] = classifier.classify(result.cells[i * step].cell, false, workspaces.local()) == kDeeper;
  });
  result.undecided = static_cast<double>(std::ranges::count(deeper, uint8_t{1})) / static_cast<double>(looks);
  return result;
}

// Of the weight of all cells of the level, what its bricks leave if the heaviest cells get theirs. As much as there are
// lines that are alone in their cell goes to cells that no line shows (Good 1953). The bytes that are left are for
// these: as many as for the others get half of that weight.
double left_by_bricks(Level&& level, double bytes) {
  std::ranges::sort(level.cells, std::ranges::greater{}, &Asked::weight);
  double weight = 0, with_brick = 0, bricks = 0, lines = 0, alone = 0;
  for (const Asked& cell : level.cells) {
    weight += cell.weight;
    lines += static_cast<double>(cell.end - cell.begin);
    alone += cell.end - cell.begin == 1;
    bricks += level.undecided;
    if (bricks * kBrickBytes <= bytes) with_brick = weight;
  }
  if (!(weight > 0)) return 0;
  const double unseen = alone / lines, more = std::max(bytes / kBrickBytes - bricks, 0.0);
  const double divided = (1 - unseen) * with_brick / weight + unseen * more / (more + bricks + 1);
  return level.undecided * (1 - (1 - kLeftByBrick) * divided);
}

}  // namespace

uint32_t pick_depth(const CellClassifier& classifier, const std::vector<AskedLine>& lines, uint64_t budget_bytes,
                    const std::function<bool()>& over) {
  Workspaces workspaces;
  const uint32_t top_level = tree_shape(kMaxDepth).top_levels;  // of all depths that have inner blocks
  const std::vector<Asked> top = undecided_cells(classifier, lines, top_level, workspaces, over);
  uint32_t best = kMinDepth + 1;
  for (uint32_t depth = best; depth <= top_level + 1; ++depth)
    if (tree_shape(depth).top_bytes() <= budget_bytes / 2) best = depth;
  const auto weight_of = [](double sum, const auto& part) { return sum + part.weight; };
  const double asked = std::accumulate(lines.begin(), lines.end(), 0.0, weight_of),
               undecided = std::accumulate(top.begin(), top.end(), 0.0, weight_of);
  double least = 1;  // of what is undecided
  for (uint32_t depth = top_level + 2; depth <= kMaxDepth && !over(); ++depth) {
    const std::vector<Step> steps = steps_of(depth);
    double bytes = static_cast<double>(budget_bytes) - static_cast<double>(tree_shape(depth).top_bytes());
    for (size_t i = 0; i + 1 < steps.size(); ++i)
      bytes -= look_at(classifier, lines, top, steps[i].from, workspaces).count() * kBlockBytes;
    if (bytes < 0) continue;
    const double left = left_by_bricks(look_at(classifier, lines, top, steps.back().from, workspaces), bytes);
    if ((least - left) * undecided >= kWorthALevel * asked) best = depth, least = left;
  }
  return best;
}

}  // namespace vcd::baker
