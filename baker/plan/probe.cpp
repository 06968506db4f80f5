#include "probe.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include <vcd/baker/audit.h>
#include <vcd/format/line_cell.h>
#include <vcd/format/tree.h>

#include "seconds_since.h"

namespace vcd::baker {
namespace {

constexpr uint32_t kMostPaths = 600, kFewestPaths = 60;
constexpr uint64_t kPathTriangles = 60'000'000;  // a path's cells near the root cost time with the mesh's size
constexpr uint32_t kMostSegments = 1000, kFewestSegments = 200;
constexpr double kProbeShare = 0.15;      // of the seconds that there are, for the paths, and as much for the segments
constexpr double kLookUpSeconds = 14e-9;  // of one segment: spec/results.md, "Look-ups: single calls"
constexpr uint32_t kLevels = 9;           // 0 … 8
constexpr uint32_t kLeastDepth = 3;
constexpr uint32_t kComparedPaths = 150, kLeastCompared = 2,
                   kMostCompared = 4;  // how often, and at which levels, bricks are compared

using Clock = std::chrono::steady_clock;
double all_cells(uint32_t level) { return kFacePairs * std::exp2(4.0 * level); }

// Estimates of sums over all cells of a level that a bake visits, if it goes at least one level deeper.
struct LevelSums {
  double visited = 0;   // cells
  double seconds = 0;   // to classify them
  double resolved = 0;  // cells that are clear or blocked
  double undecided = 0;
  double as_leaves_seconds = 0;  // what the undecided ones would cost beyond that as cells of the deepest level
  double as_leaves_blocked = 0;  // and how many would be statistically blocked
  std::array<double, 2> dull{};  // undecided ones whose 16 children, and whose 256 grandchildren, are all undecided
  double compared = 0, repeated = 0;  // undecided cells, as bricks; those that equal one before them
};

// The cell of the same lines moved one cell towards the beginning of an axis; none where a face would have to move.
std::optional<Cell> previous(const Cell& cell, uint32_t axis) {
  Cell before = cell;
  const FaceAxes low = face_axes(kFacePair[cell.pair].low), high = face_axes(kFacePair[cell.pair].high);
  if (low.normal == axis || high.normal == axis) return std::nullopt;
  uint32_t& first = low.first == axis ? before.s : before.t;
  uint32_t& second = high.first == axis ? before.u : before.v;
  if (first-- == 0 || second-- == 0) return std::nullopt;
  return before;
}

class Probe {
 public:
  Probe(const CellClassifier& classifier, const ProbeOptions& options) : classifier_(classifier), options_(options) {}

  // Each path stands for a tree: the sums over its cells, weighted by how many each stands for, have the right mean
  // (Knuth 1975, "Estimating the efficiency of backtrack programs").
  void run(uint32_t most) {
    const auto start = Clock::now();
    uint32_t paths = 0;
    while (paths < most && !(options_.stop && options_.stop()) &&
           seconds_since(start) < kProbeShare * options_.budget_seconds)
      walk(paths++);
    for (LevelSums& l : levels_)
      for (double* sum : {&l.visited, &l.seconds, &l.resolved, &l.undecided, &l.as_leaves_seconds, &l.as_leaves_blocked,
                          &l.dull[0], &l.dull[1], &l.compared, &l.repeated})
        *sum /= std::max(paths, 1u);
  }

  double seconds(uint32_t depth) const {
    double sum = levels_[depth].as_leaves_seconds;
    for (uint32_t l = 0; l <= depth; ++l) sum += levels_[l].seconds;
    return sum;
  }
  double resolved(uint32_t depth) const {
    double share = levels_[depth].as_leaves_blocked / all_cells(depth);
    for (uint32_t l = 0; l <= depth; ++l) share += levels_[l].resolved / all_cells(l);
    return share;
  }
  uint64_t bytes(uint32_t depth) const {
    const TreeShape shape = tree_shape(depth);
    const auto mixed = [&](uint32_t level) { return static_cast<uint64_t>(levels_[level].undecided); };
    const uint32_t brick_level = shape.levels - 2;
    double bricks = depth < 2 ? kFacePairs : levels_[brick_level].undecided - levels_[brick_level].dull[1];
    const LevelSums& seen = levels_[std::min(brick_level, kMostCompared)];
    if (seen.compared > 0) bricks *= 1 - seen.repeated / seen.compared;
    uint64_t sum = shape.least_bytes() + static_cast<uint64_t>(bricks) * kBrickBytes;
    for (uint32_t level = shape.top_levels; level < brick_level; ++level) sum += mixed(level) * kBlockBytes;
    return sum;
  }

 private:
  uint32_t classify(const Cell& cell, bool deepest, double& seconds) {
    const auto start = Clock::now();
    const uint32_t value = classifier_.classify(cell, deepest, workspace_);
    seconds += seconds_since(start);
    return value;
  }

  void walk(uint32_t path) {
    std::mt19937_64 random(path);
    Cell cell{path % kFacePairs, 0, 0, 0, 0, 0};
    double weight = kFacePairs;  // cells that `cell` stands for
    LevelSums& root = levels_[0];
    double seconds = 0;
    root.visited += weight;
    const bool undecided = classify(cell, false, seconds) == kDeeper;
    root.seconds += weight * seconds;
    (undecided ? root.undecided : root.resolved) += weight;
    if (!undecided) return;
    while (cell.level < options_.deepest) {
      LevelSums& above = levels_[cell.level];
      LevelSums& level = levels_[cell.level + 1];
      std::vector<Cell> open;
      const auto start = Clock::now();
      for (uint32_t i = 0; i < 16; ++i)
        if (classifier_.classify(cell.child(i), false, workspace_) == kDeeper) open.push_back(cell.child(i));
      level.seconds += weight * seconds_since(start);
      level.visited += weight * 16;
      level.resolved += weight * static_cast<double>(16 - open.size());
      level.undecided += weight * static_cast<double>(open.size());
      above.dull[0] += open.size() == 16 ? weight : 0;
      above.dull[1] += open.size() == 16 && cell.level + 2 <= options_.deepest && all_undecided(open) ? weight : 0;
      if (cell.level >= kLeastCompared && cell.level <= kMostCompared && path < kComparedPaths &&
          cell.level + 2 <= options_.deepest) {
        above.compared += weight;
        for (uint32_t axis = 0; axis < 3; ++axis)
          if (const auto before = previous(cell, axis); before && same_brick(cell, *before)) {
            above.repeated += weight;
            break;
          }
      }
      if (open.empty()) return;
      cell = open[random() % open.size()];
      weight *= static_cast<double>(open.size());
      // What all sixteen siblings share is paid by the first of them only. The least of two times: the machine may be
      // shared.
      double first = 0, next = 0, again = 0, as_node = 0, once_more = 0;
      const uint32_t leaf = classify(cell, true, first);
      classify(cell, true, next), classify(cell, true, again);
      classify(cell, false, as_node), classify(cell, false, once_more);
      next = std::min(next, again), as_node = std::min(as_node, once_more);
      level.as_leaves_seconds += weight * (next + std::max(first - next, 0.0) / 16 - as_node);
      level.as_leaves_blocked += leaf == kStatisticallyBlocked ? weight : 0;
    }
  }

  // Bricks that are equal are stored once; most that are stand side by side, along an edge or a flat part.
  bool same_brick(const Cell& a, const Cell& b) {
    for (uint32_t i = 0; i < 16; ++i) {
      const Cell x = a.child(i), y = b.child(i);
      const uint32_t value = classifier_.classify(x, false, workspace_);
      if (classifier_.classify(y, false, workspace_) != value) return false;
      for (uint32_t j = 0; j < 16 && value == kDeeper; ++j)
        if (classifier_.classify(x.child(j), true, workspace_) != classifier_.classify(y.child(j), true, workspace_))
          return false;
    }
    return true;
  }

  bool all_undecided(const std::vector<Cell>& cells) {
    for (const Cell& cell : cells)
      for (uint32_t i = 0; i < 16; ++i)
        if (classifier_.classify(cell.child(i), true, workspace_) != kUnclassified) return false;
    return true;
  }

  const CellClassifier& classifier_;
  const ProbeOptions& options_;
  Workspace workspace_;
  std::array<LevelSums, kLevels> levels_;
};

// Shadow-like segments: at which depth each is answered, and what tracing it costs.
class Shadows {
 public:
  Shadows(const PreparedMesh& mesh, const Tracer& tracer, const CellClassifier& classifier, const ProbeOptions& options,
          uint32_t segments) {
    const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
    Workspace workspace;
    const auto beginning = Clock::now();
    for (Segment segment : audit_segments(mesh, AuditKind::chords, 0x5AD0, segments)) {
      const LineCell line = locate(frame, segment);
      if (!line.valid || !line.hits || (options.stop && options.stop())) continue;
      if (seconds_since(beginning) > kProbeShare * options.budget_seconds) break;
      Answered answered;
      for (uint32_t level = 0; level <= options.deepest && !answered.by_node; ++level) {
        const uint32_t up = 8 - level;
        const Cell cell{line.pair, level, line.s >> up, line.t >> up, line.u >> up, line.v >> up};
        answered.by_node = classifier.classify(cell, false, workspace) != kDeeper;
        answered.depth = level;
        if (!answered.by_node) answered.as_leaf[level] = classifier.classify(cell, true, workspace) != kUnclassified;
      }
      for (int a = 0; a < 3; ++a) {
        segment.direction[a] *= frame.scale[a];
        segment.origin[a] = to_grid(frame, a, segment.origin[a]);
      }
      // The shortest of some tries: whoever took the processor away meanwhile would count as tracing.
      answered.trace_seconds = std::numeric_limits<double>::infinity();
      for (int t = 0; t < kTries; ++t) {
        const auto start = Clock::now();
        for (int i = 0; i < kRepeats; ++i) tracer.occluded(segment);
        answered.trace_seconds = std::min(answered.trace_seconds, seconds_since(start) / kRepeats);
      }
      segments_.push_back(answered);
    }
  }

  double resolved(uint32_t depth) const {
    double count = 0;
    for (const Answered& a : segments_) count += a.at(depth);
    return count / static_cast<double>(std::max<size_t>(segments_.size(), 1));
  }
  double gain(uint32_t depth) const {
    double trace = 0, rest = 0;
    for (const Answered& a : segments_) trace += a.trace_seconds, rest += a.at(depth) ? 0 : a.trace_seconds;
    return segments_.empty() ? 1 : trace / (kLookUpSeconds * static_cast<double>(segments_.size()) + rest);
  }

 private:
  static constexpr int kTries = 3, kRepeats = 3;

  struct Answered {
    bool by_node = false;
    uint32_t depth = 0;  // if by_node
    std::array<bool, kLevels> as_leaf{};
    double trace_seconds = 0;
    bool at(uint32_t d) const { return (by_node && depth <= d) || as_leaf[d]; }
  };
  std::vector<Answered> segments_;
};

std::string percent(double share) { return std::to_string(static_cast<int>(std::lround(100 * share))) + " %"; }

void choose(const ProbeOptions& options, Plan& plan) {
  const auto fits = [&](const DepthForecast& f) {
    return f.bytes <= 2 * options.budget_bytes && tree_shape(f.depth).top_bytes() <= options.budget_bytes / 2 &&
           (f.seconds <= options.budget_seconds || f.depth == kLeastDepth);  // a deadline ends what takes too long
  };
  for (size_t i = kLeastDepth - 1; i < plan.forecasts.size(); ++i) {
    const DepthForecast& f = plan.forecasts[i];
    if (!fits(f)) {
      plan.reason = f.seconds > options.budget_seconds ? "the next level would take longer than there is time"
                                                       : "the next level would not fit";
      break;
    }
    if (plan.depth > 0 && f.resolved_shadow < plan.forecasts[plan.depth - 1].resolved_shadow + 0.02) {
      plan.reason = "the next level would resolve hardly more";
      break;
    }
    plan.depth = f.depth;
    plan.reason = "it is the deepest that was forecast";
  }
  if (plan.depth == 0) return;
  if (const double resolved = plan.forecasts[plan.depth - 1].resolved_shadow; resolved < kLeastResolved) {
    plan.depth = 0;
    plan.reason = "it would resolve only " + percent(resolved) + " of segments";
  }
}

}  // namespace

Plan probe(const PreparedMesh& mesh, const Tracer& tracer, const CellClassifier& classifier,
           const ProbeOptions& options) {
  const auto start = Clock::now();
  Plan plan;
  if (mesh.triangles.size() < kLeastTriangles) {
    plan.reason = "its " + std::to_string(mesh.triangles.size()) + " triangles are traced as fast as looked up";
    return plan;
  }
  Probe paths(classifier, options);
  const auto share = [&](uint32_t fewest, uint32_t most) {
    return static_cast<uint32_t>(
        std::clamp<uint64_t>(most * kPathTriangles / kMostPaths / mesh.triangles.size(), fewest, most));
  };
  paths.run(share(kFewestPaths, kMostPaths));
  const Shadows shadows(mesh, tracer, classifier, options, share(kFewestSegments, kMostSegments));
  for (uint32_t depth = 1; depth <= options.deepest; ++depth)
    plan.forecasts.push_back({depth, paths.bytes(depth), paths.seconds(depth) / options.threads, paths.resolved(depth),
                              shadows.resolved(depth), shadows.gain(depth)});
  choose(options, plan);
  plan.seconds = seconds_since(start);
  return plan;
}

}  // namespace vcd::baker
