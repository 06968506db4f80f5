// Which cells to divide for a demand: those first whose division is worth most.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <vcd/baker/bake.h>

#include "classify/cell_classifier.h"
#include "demand/asked_lines.h"
#include "demand/divided_cells.h"
#include "demand/known_cells.h"

namespace vcd::baker {

struct BestFirstOptions {
  uint32_t depth;                // 2 to 8; 0: pick_depth()
  uint64_t budget_bytes;         // of the tree
  uint32_t depth_elsewhere = 0;  // BakeOptions::depth_elsewhere
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::function<bool()> stop = {};
  std::function<void(double fraction, uint64_t rays)> progress = {};  // of the budgets; from one thread
};

struct BestFirst {
  uint32_t depth;
  DividedCells cells;
  uint64_t rays = 0, classified = 0;  // classified: cells that were not known
  bool out_of_time = false;
  bool too_deep_elsewhere = false;  // depth_elsewhere takes more than the budget; then nothing else holds
  std::vector<WorthOfBytes> worth = {};
};

// Classifies the cells of the top table. Then divides cells that lines are asked of and that their class does not
// answer, as long as the budgets last and they are worth their bytes. The next is
// always the one of most asked weight for a byte of its block; where there is a deadline, for its share of the bytes
// and of the time, by the mean of such blocks so far. All cells of a block are classified, asked or not: their bytes
// are paid. Some of the weight goes to cells without a line, which the next picture may ask.
//
// What depth_elsewhere asks for is divided before. What the known tree divides and nobody asks for is divided last.
//
// The tree of the divided cells takes at most budget_bytes. Without a deadline, the same lines and options give the
// same cells for any number of threads. Runs on the threads of the caller's arena. Nothing if stop stopped it.
std::optional<BestFirst> divide_best_first(const KnownCells& classifier, const std::vector<AskedLine>& lines,
                                           const BestFirstOptions& options);

}  // namespace vcd::baker
