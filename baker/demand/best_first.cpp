#include "demand/best_first.h"

#include <algorithm>
#include <array>
#include <queue>
#include <utility>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "octree/block_pool.h"
#include "octree/subtree.h"

namespace vcd::baker {
namespace {

using Clock = std::chrono::steady_clock;

// Cells that are divided at once, before the next are chosen. Not the number of threads: results would depend on it.
constexpr size_t kBatch = 1024;

// A cell that its class does not answer, and the lines that are asked of it.
struct Asked {
  Cell cell;
  size_t begin, end;
  double weight;

  // Of a heap: the heaviest first.
  bool operator<(const Asked& o) const { return weight != o.weight ? weight < o.weight : begin > o.begin; }
};

class Divider {
 public:
  Divider(const CellClassifier& classifier, const std::vector<AskedLine>& lines, const BestFirstOptions& options)
      : classifier_(classifier), lines_(lines), options_(options), result_{DividedCells(options.depth)} {
    const TreeShape shape = tree_shape(options.depth);
    constexpr uint64_t kAlways = kUniformBlocks + 1;  // and one for cells that are statistically blocked as a whole
    bytes_ = shape.bytes(shape.has_blocks256 ? kAlways : 0, shape.has_blocks16 ? kAlways : 0, kAlways);
    costs_.resize(steps().size());
    queues_.resize(steps().size());
    for (uint32_t i = 0; i < kUniformBlocks; ++i) bricks_.intern(pattern(i).data());
  }

  std::optional<BestFirst> run() {
    find_top_cells();
    for (;;) {
      const std::vector<Job> jobs = next_jobs();
      if (jobs.empty()) break;
      std::vector<Filled> filled(jobs.size());
      tbb::parallel_for(size_t{0}, jobs.size(), [&](size_t i) { filled[i] = fill(jobs[i]); });
      if (options_.stop && options_.stop()) return std::nullopt;
      for (size_t i = 0; i < jobs.size(); ++i) take(jobs[i], filled[i]);
      count_rays();
      if (options_.progress) options_.progress(fraction(), result_.rays);
    }
    count_rays();
    return std::move(result_);
  }

 private:
  struct Job {
    size_t step;
    Asked asked;
  };
  struct Filled {
    std::vector<uint8_t> classes;  // empty: there was no time
    double seconds = 0;
  };
  struct Cost {  // of the blocks of one step so far
    double seconds = 0;
    uint64_t blocks = 0;
  };

  const std::vector<Step>& steps() const { return result_.cells.steps(); }
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
    for (Workspace& workspace : workspaces_) result_.rays += std::exchange(workspace.rays, 0);
  }

  // Those of the top table that lines are asked of, and that neither they nor a cell above decides.
  void find_top_cells() {
    std::vector<Asked> cells;
    for (size_t i = 0; i < lines_.size();) {
      const auto pair = static_cast<uint32_t>(lines_[i].key >> (4 * kKeyLevels));
      cells.push_back(below({{pair, 0, 0, 0, 0, 0}, i, lines_.size(), 0}, pair, 4 * kKeyLevels));
      i = cells.back().end;
    }
    for (uint32_t level = 0;; ++level) {
      std::vector<uint8_t> deeper(cells.size());
      tbb::parallel_for(size_t{0}, cells.size(), [&](size_t i) {
        deeper[i] = !over() && classifier_.classify(cells[i].cell, false, workspaces_.local()) == kDeeper;
      });
      std::vector<Asked> undecided;
      for (size_t i = 0; i < cells.size(); ++i)
        if (deeper[i]) undecided.push_back(cells[i]);
      if (level == result_.cells.top_level()) {
        for (const Asked& cell : undecided) queues_[0].push(cell);
        return;
      }
      cells.clear();
      for (const Asked& cell : undecided) for_children(cell, [&](const Asked& child) { cells.push_back(child); });
    }
  }

  // `asked` with those of its lines, from the first on, whose keys begin with `prefix`.
  Asked below(Asked asked, uint64_t prefix, uint32_t shift) const {
    size_t i = asked.begin;
    for (; i < asked.end && lines_[i].key >> shift == prefix; ++i) asked.weight += lines_[i].weight;
    asked.end = i;
    return asked;
  }

  // The children that lines are asked of.
  template <class Each>
  void for_children(const Asked& parent, const Each& each) const {
    const uint32_t level = parent.cell.level + 1, shift = 4 * (kKeyLevels - level);
    for (size_t i = parent.begin; i < parent.end;) {
      const Cell cell = parent.cell.child(child_of(lines_[i].key, level));
      const Asked child = below({cell, i, parent.end, 0}, lines_[i].key >> shift, shift);
      each(child);
      i = child.end;
    }
  }

  // What a block of the step takes of the budgets.
  double cost(size_t step) const {
    const double share = static_cast<double>(steps()[step].block_bytes) / static_cast<double>(options_.budget_bytes);
    if (options_.deadline == Clock::time_point::max() || costs_[step].blocks == 0) return share;
    const std::chrono::duration<double> time = options_.deadline - start_;
    return share + costs_[step].seconds / static_cast<double>(costs_[step].blocks) / time.count();
  }

  // The step with the cell that is worth most for what it costs; none: no cell is left.
  std::optional<size_t> best_step() const {
    std::optional<size_t> best;
    double most = 0;
    for (size_t s = 0; s < steps().size(); ++s) {
      const double worth = queues_[s].empty() ? 0 : queues_[s].top().weight / cost(s);
      if (worth > most) best = s, most = worth;
    }
    return best;
  }

  // The next batch; what it could take at most fits. Empty: nothing is left that fits.
  std::vector<Job> next_jobs() {
    std::vector<Job> jobs;
    uint64_t reserved = 0;
    if (over()) result_.out_of_time = true;
    while (jobs.size() < kBatch && !result_.out_of_time) {
      const auto best = best_step();
      if (!best) break;
      const uint64_t bytes = steps()[*best].block_bytes;
      if (bytes_ + reserved + bytes > options_.budget_bytes) {
        if (!jobs.empty()) break;  // of what is reserved, some may turn out to be equal to what is there
        queues_[*best] = {};       // the others of the step are as large
        continue;
      }
      reserved += bytes;
      jobs.push_back({*best, queues_[*best].top()});
      queues_[*best].pop();
    }
    return jobs;
  }

  Filled fill(const Job& job) {
    Filled filled;
    if (over() || (options_.stop && options_.stop())) return filled;
    const auto begin = Clock::now();
    const Step& step = steps()[job.step];
    filled.classes.resize(step.children());
    fill_below(job.asked.cell, step, kDeeper, workspaces_.local(), filled.classes);
    filled.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
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

  void take(const Job& job, Filled& filled) {
    if (filled.classes.empty()) {
      result_.out_of_time = true;
      return;
    }
    const Step& step = steps()[job.step];
    costs_[job.step].seconds += filled.seconds;
    ++costs_[job.step].blocks;
    if (step.to == options_.depth) {
      bytes_ += new_brick_bytes(filled.classes);
    } else {
      bytes_ += step.block_bytes;
      queue_undecided(job.step, job.asked, filled.classes);
    }
    result_.cells.divide(job.asked.cell, filled.classes);
  }

  void queue_undecided(size_t step, const Asked& asked, std::vector<uint8_t>& classes) {
    for_children(asked, [&](const Asked& child) {
      if (child.cell.level < steps()[step].to) return queue_undecided(step, child, classes);
      uint8_t& value = classes[steps()[step].index(child.cell)];
      if (value != kDeeper) return;
      value = DividedCells::kAsked;
      queues_[step + 1].push(child);
    });
  }

  uint64_t new_brick_bytes(const std::vector<uint8_t>& classes) {
    BrickWords words{};
    for (size_t i = 0; i < classes.size(); ++i) words[i / 16] |= uint32_t{classes[i]} << (2 * (i % 16));
    const uint64_t before = bricks_.count();
    bricks_.intern(words.data());
    return (bricks_.count() - before) * kBrickBytes;
  }

  const CellClassifier& classifier_;
  const std::vector<AskedLine>& lines_;
  const BestFirstOptions& options_;
  const Clock::time_point start_ = Clock::now();
  BestFirst result_;
  tbb::enumerable_thread_specific<Workspace> workspaces_;
  std::vector<std::priority_queue<Asked>> queues_;  // of each step
  std::vector<Cost> costs_;
  BrickPool bricks_;    // equal ones take their bytes once
  uint64_t bytes_ = 0;  // that the tree takes at most
};

}  // namespace

std::optional<BestFirst> divide_best_first(const CellClassifier& classifier, const std::vector<AskedLine>& lines,
                                           const BestFirstOptions& options) {
  return Divider(classifier, lines, options).run();
}

}  // namespace vcd::baker
