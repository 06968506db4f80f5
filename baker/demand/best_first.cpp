#include "demand/best_first.h"

#include <algorithm>
#include <array>
#include <queue>
#include <unordered_set>
#include <utility>

#include <tbb/parallel_for.h>

#include "demand/asked_cells.h"
#include "demand/divided_bytes.h"
#include "octree/block_pool.h"
#include "octree/subtree.h"
#include "seconds_since.h"

namespace vcd::baker {
namespace {

using Clock = std::chrono::steady_clock;

// Cells that are divided at once, before the next are chosen. Not the number of threads: results would depend on it.
constexpr size_t kBatch = 1024;

// What a block must be expected to be asked of all weight: else it is not worth its bytes.
constexpr double kLeastWeight = 0x1p-26;

class Divider {
 public:
  Divider(const KnownCells& classifier, const std::vector<AskedLine>& lines, const BestFirstOptions& options)
      : classifier_(classifier), lines_(lines), options_(options), result_{options.depth, DividedCells(options.depth)} {
    bytes_ = bytes_of(result_.cells);
    double weight = 0;
    for (const AskedLine& line : lines) weight += line.weight;
    least_weight_ = kLeastWeight * weight;
    costs_.resize(steps().size());
    queues_.resize(steps().size());
    for (uint32_t i = 0; i < kUniformBlocks; ++i) bricks_.intern(pattern(i).data());
  }

  std::optional<BestFirst> run() {
    classify_top();
    for (const Asked& cell :
         undecided_cells(classifier_, lines_, result_.cells.top_level(), workspaces_, [&] { return over(); }))
      queues_[0].push(cell);
    queue_not_asked();
    result_.too_deep_elsewhere = options_.depth_elsewhere > 0 && bytes_ > options_.budget_bytes;
    for (;;) {
      const std::vector<Job> jobs = next_jobs();
      if (result_.too_deep_elsewhere) return std::move(result_);
      if (jobs.empty()) break;
      std::vector<Filled> filled(jobs.size());
      tbb::parallel_for(size_t{0}, jobs.size(), [&](size_t i) { filled[i] = fill(jobs[i]); });
      if (options_.stop && options_.stop()) return std::nullopt;
      for (size_t i = 0; i < jobs.size(); ++i) take(jobs[i], filled[i]);
      count_rays();
      if (options_.progress) options_.progress(fraction(), result_.rays);
    }
    count_rays();
    result_.worth.push_back({bytes_, 0});
    return std::move(result_);
  }

 private:
  struct Job {
    size_t step;
    Asked asked;
  };
  struct Filled {
    std::vector<uint8_t> classes;   // empty: there was no time
    std::vector<Asked> with_lines;  // of its cells, those that no class answers
    double seconds = 0;
  };
  struct Cost {  // of the blocks of one step so far
    double seconds = 0;
    uint64_t blocks = 0;
  };

  // The classes of the top table. A class above it holds for all cells below.
  void classify_top() {
    const uint32_t top_level = result_.cells.top_level(), first_level = std::min(top_level, 1u);
    result_.cells.top.assign(size_t{kFacePairs} << (4 * top_level), static_cast<uint8_t>(kUnclassified));
    const uint32_t each = 1u << (4 * first_level);
    tbb::parallel_for(0u, kFacePairs * each, [&](uint32_t i) {
      const Cell root{i / each, 0, 0, 0, 0, 0};
      Workspace& workspace = workspaces_.local();
      uint32_t value = first_level == 0 ? kDeeper : classifier_.classify(root, false, workspace);
      classify_top(first_level == 0 ? root : root.child(i % each), value, workspace);
    });
  }
  void classify_top(const Cell& cell, uint32_t value, Workspace& workspace) {
    const uint32_t level = result_.cells.top_level();
    if (over() || (options_.stop && options_.stop())) return;
    if (value == kDeeper) value = classifier_.classify(cell, cell.level == level, workspace);
    if (cell.level == level) {
      result_.cells.top[cell.pair << (4 * level) | row_major(cell.s, cell.t, cell.u, cell.v, 0, level)] =
          static_cast<uint8_t>(value);
      return;
    }
    for (uint32_t i = 0; i < 16; ++i) classify_top(cell.child(i), value, workspace);
  }

  const std::vector<Step>& steps() const { return result_.cells.steps(); }
  // Whether all cells are divided by the step, asked or not: before all others.
  bool everywhere(size_t step) const { return steps()[step].to <= options_.depth_elsewhere; }
  // Cells of the top table that nobody asks for and that are divided all the same.
  void queue_not_asked() {
    std::unordered_set<uint64_t> asked;
    for (const AskedLine& line : lines_) asked.insert(line.key >> (4 * (kKeyLevels - result_.cells.top_level())));
    result_.cells.for_top([&](const Cell& cell) {
      const bool divided =
          classifier_.divides(cell) || (everywhere(0) && result_.cells.class_on_top(cell) == kUnclassified);
      if (divided && !asked.contains(cell_in_keys(cell))) queues_[0].push({cell, 0, 0, least_weight_});
    });
  }
  static BrickWords pattern(uint32_t value) {
    BrickWords words;
    words.fill(value * 0x55555555u);
    return words;
  }
  bool over() const { return options_.deadline != Clock::time_point::max() && Clock::now() > options_.deadline; }
  double fraction() const {
    return std::min(1.0, static_cast<double>(bytes_) / static_cast<double>(options_.budget_bytes));
  }
  void count_rays() {
    for (Workspace& workspace : workspaces_) {
      result_.rays += std::exchange(workspace.rays, 0);
      result_.classified += std::exchange(workspace.cells, 0);
    }
  }

  // What a block of the step takes of the budgets.
  double cost(size_t step) const {
    const double share = static_cast<double>(kBlockBytes) / static_cast<double>(options_.budget_bytes);
    if (options_.deadline == Clock::time_point::max() || costs_[step].blocks == 0) return share;
    const std::chrono::duration<double> time = options_.deadline - start_;
    return share + costs_[step].seconds / static_cast<double>(costs_[step].blocks) / time.count();
  }

  // The step with the cell that is worth most for what it costs; none: no cell is left.
  std::optional<size_t> best_step() const {
    std::optional<size_t> best;
    double most = 0;
    for (size_t s = 0; s < steps().size() && everywhere(s); ++s)
      if (!queues_[s].empty()) return s;
    for (size_t s = 0; s < steps().size(); ++s) {
      if (queues_[s].empty() || queues_[s].top().weight < least_weight_) continue;
      const double worth = queues_[s].top().weight / cost(s);
      if (worth > most) best = s, most = worth;
    }
    return best;
  }

  // The next batch; what it could take at most fits. Empty: nothing is left that fits.
  std::vector<Job> next_jobs() {
    std::vector<Job> jobs;
    uint64_t reserved = 0;
    if (over()) result_.out_of_time = true;
    if (const auto best = best_step();
        result_.worth.empty() && options_.depth_elsewhere > 0 && best && !everywhere(*best))
      count_bytes_again();  // the bytes of what is divided everywhere, as they are
    while (jobs.size() < kBatch && !result_.out_of_time) {
      const auto best = best_step();
      if (!best) break;
      const uint64_t bytes = bytes_at_most(*best, queues_[*best].top().cell);
      if (bytes_ + reserved + bytes > options_.budget_bytes) {
        if (!jobs.empty()) break;  // of what is reserved, some may turn out to be equal to what is there
        if (count_bytes_again()) continue;
        if (everywhere(*best)) {
          result_.too_deep_elsewhere = true;
          break;
        }
        queues_[*best] = {};  // the others of the step are hardly smaller
        continue;
      }
      reserved += bytes;
      jobs.push_back({*best, queues_[*best].top()});
      queues_[*best].pop();
    }
    if (!jobs.empty() && !everywhere(jobs.back().step))
      result_.worth.push_back({bytes_, jobs.back().asked.weight / kBlockBytes});
    return jobs;
  }

  Filled fill(const Job& job) {
    Filled filled;
    if (over() || (options_.stop && options_.stop())) return filled;
    const auto begin = Clock::now();
    const Step& step = steps()[job.step];
    filled.classes.resize(step.children());
    Workspace& workspace = workspaces_.local();
    fill_below(job.asked.cell, step, kDeeper, workspace, filled.classes);
    mark_asked(step, job.asked, workspace, filled);
    filled.seconds = seconds_since(begin);
    return filled;
  }
  void fill_below(const Cell& cell, const Step& step, uint32_t value, Workspace& workspace,
                  std::vector<uint8_t>& classes) const {
    for (uint32_t i = 0; i < 16; ++i) {
      const Cell child = cell.child(i);
      const uint32_t below =
          value == kDeeper ? classifier_.classify(child, child.level == options_.depth, workspace) : value;
      if (child.level < step.to) fill_below(child, step, below, workspace, classes);
      else classes[step.index(child)] = static_cast<uint8_t>(below);
    }
  }

  // Those that lines are asked of, with the class that they have if they are not divided.
  void mark_asked(const Step& step, const Asked& asked, Workspace& workspace, Filled& filled) const {
    for_children(lines_, asked, [&](const Asked& child) {
      if (child.cell.level < step.to) return mark_asked(step, child, workspace, filled);
      uint8_t& value = filled.classes[step.index(child.cell)];
      if (value != kDeeper) return;
      value = static_cast<uint8_t>(DividedCells::kAsked + classifier_.classify(child.cell, true, workspace));
      filled.with_lines.push_back(child);
    });
  }

  void take(const Job& job, Filled& filled) {
    if (filled.classes.empty()) {
      result_.out_of_time = true;
      return;
    }
    const Step& step = steps()[job.step];
    costs_[job.step].seconds += filled.seconds;
    ++costs_[job.step].blocks;
    const bool is_brick = step.to == options_.depth;
    if (says_something(filled.classes)) {
      if (is_brick) bytes_ += new_brick_bytes(filled.classes);
      pay_inner_blocks(is_brick ? job.step : job.step + 1, job.asked.cell);
    }
    if (!is_brick) queue_undecided(job, filled);
    result_.cells.divide(job.asked.cell, filled.classes);
  }

  // A block takes bytes only where some cell of it, or below it, has a class: all others are one.
  static bool says_something(const std::vector<uint8_t>& classes) {
    constexpr uint8_t kAskedButUnclassified = DividedCells::kAsked + static_cast<uint8_t>(kUnclassified);
    return std::ranges::any_of(
        classes, [](uint8_t c) { return c != kUnclassified && c != kDeeper && c != kAskedButUnclassified; });
  }
  static Cell above(Cell cell, uint32_t level) {
    while (cell.level > level) cell = cell.parent();
    return cell;
  }
  // The inner blocks of the steps before `end` that hold the cell: those that are not paid yet.
  void pay_inner_blocks(size_t end, const Cell& cell) {
    while (end-- > 0 && paid_.insert(cell_key(above(cell, steps()[end].from))).second) bytes_ += kBlockBytes;
  }
  // True if the tree takes notably less than was reckoned, because blocks are equal. These may differ once something
  // below them is divided: all are reckoned as new again.
  bool count_bytes_again() {
    const uint64_t counted = bytes_of(result_.cells);
    if (counted + options_.budget_bytes / 64 > bytes_) return false;
    bytes_ = counted;
    paid_.clear();
    return true;
  }
  uint64_t bytes_at_most(size_t step, const Cell& cell) const {
    uint64_t bytes = kBlockBytes;
    while (step-- > 0 && !paid_.contains(cell_key(above(cell, steps()[step].from)))) bytes += kBlockBytes;
    return bytes;
  }

  // Queues the cells of a block that their class does not answer. Each takes the weight of its lines. But as much of it
  // as there are lines that are alone in their cell goes to the cells without a line, in equal parts: the next picture
  // will ask some of those (Good, "The population frequencies of species and the estimation of population parameters",
  // 1953).
  void queue_undecided(const Job& job, Filled& filled) {
    auto& [classes, with_lines, seconds] = filled;
    const auto others = static_cast<double>(std::ranges::count(classes, static_cast<uint8_t>(kDeeper)));
    double lines = 0, alone = 0, weight = 0;
    for (const Asked& cell : with_lines) {
      lines += static_cast<double>(cell.end - cell.begin);
      alone += cell.end - cell.begin == 1;
      weight += cell.weight;
    }
    // Of a block that no line asked for, each cell has its part.
    const double unseen = others > 0 ? alone / (lines + 1) : 0;
    const double of_each_other = job.asked.begin == job.asked.end
                                     ? job.asked.weight / static_cast<double>(classes.size())
                                     : unseen * weight / std::max(others, 1.0);
    for (Asked& cell : with_lines) {
      cell.weight *= 1 - unseen;
      queues_[job.step + 1].push(cell);
    }
    for (uint32_t i = 0; i < classes.size(); ++i) {
      if (classes[i] != kDeeper) continue;
      const Cell cell = steps()[job.step].cell(job.asked.cell, i);
      const bool divided = everywhere(job.step + 1) || classifier_.divides(cell);
      const double least = divided ? least_weight_ : 0;
      if (const double of_it = std::max(of_each_other, least); of_it > 0)
        queues_[job.step + 1].push({cell, 0, 0, of_it});
    }
  }

  uint64_t new_brick_bytes(const std::vector<uint8_t>& classes) {
    BrickWords words{};
    for (size_t i = 0; i < classes.size(); ++i) words[i / 16] |= uint32_t{classes[i]} << (2 * (i % 16));
    const uint64_t before = bricks_.count();
    bricks_.intern(words.data());
    return (bricks_.count() - before) * kBrickBytes;
  }

  const KnownCells& classifier_;
  const std::vector<AskedLine>& lines_;
  const BestFirstOptions& options_;
  const Clock::time_point start_ = Clock::now();
  BestFirst result_;
  Workspaces workspaces_;
  std::vector<std::priority_queue<Asked>> queues_;  // of each step
  std::vector<Cost> costs_;
  BlockPool bricks_;                   // equal ones take their bytes once
  std::unordered_set<uint64_t> paid_;  // cells whose inner blocks are among the bytes
  uint64_t bytes_ = 0;                 // that the tree takes at most
  double least_weight_;                // of a block that is just worth its bytes: it comes after all that is asked
};

}  // namespace

std::optional<BestFirst> divide_best_first(const KnownCells& classifier, const std::vector<AskedLine>& lines,
                                           const BestFirstOptions& options) {
  BestFirstOptions chosen = options;
  const auto over = [&] { return options.deadline != Clock::time_point::max() && Clock::now() > options.deadline; };
  if (chosen.depth == 0)
    chosen.depth = std::max(pick_depth(classifier, lines, options.budget_bytes, over), options.depth_elsewhere);
  return Divider(classifier, lines, chosen).run();
}

}  // namespace vcd::baker
