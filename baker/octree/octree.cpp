#include "octree.h"

#include <algorithm>
#include <utility>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <vcd/baker/threads.h>

namespace vcd::baker {
namespace {

// Top cells that travel through the pipeline together: many where each is little work.
constexpr uint32_t batch_size(uint32_t depth) { return depth < 6 ? 16 : depth < 7 ? 4 : 1; }

using Workspaces = tbb::enumerable_thread_specific<Workspace>;

// Where an ancestor of the top cells decides, its class; kDeeper elsewhere. In the order of the top table.
class Ancestors {
 public:
  Ancestors(const CellSource& source, const TreeShape& shape, Workspaces& workspaces)
      : source_(source), levels_(shape.top_levels), values_(shape.top_words(), kDeeper) {
    tbb::parallel_for(0u, kFacePairs, [&](uint32_t pair) {
      visit({pair, 0, 0, 0, 0, 0}, kDeeper, workspaces.local());
    });
  }
  uint32_t operator[](uint32_t slot) const { return values_[slot]; }

 private:
  void visit(const Cell& cell, uint32_t value, Workspace& workspace) {
    if (cell.level == levels_) {
      values_[cell.pair << (4 * levels_) | row_major(cell.s, cell.t, cell.u, cell.v, 0, levels_)] = value;
      return;
    }
    if (value == kDeeper) value = source_.classify(cell, workspace);
    for (uint32_t i = 0; i < 16; ++i) visit(cell.child(i), value, workspace);
  }

  const CellSource& source_;
  uint32_t levels_;
  std::vector<uint32_t> values_;
};

Cell top_cell(const TreeShape& shape, uint32_t slot) {
  const uint32_t bits = shape.top_levels, mask = (1u << bits) - 1;
  return {slot >> (4 * bits),  bits,       slot >> (3 * bits) & mask, slot >> (2 * bits) & mask,
          slot >> bits & mask, slot & mask};
}

std::optional<Octree> build(const CellSource& source, const OctreeProgress& progress) {
  const TreeShape shape = tree_shape(source.depth);
  const uint32_t total = shape.top_words();
  Workspaces workspaces;
  const Ancestors ancestors(source, shape, workspaces);
  DagBuilder dag(source.depth);
  uint64_t rays = 0;
  for (Workspace& workspace : workspaces) rays += std::exchange(workspace.rays, 0);
  uint32_t next = 0, done = 0;
  const uint32_t step = batch_size(source.depth);
  const auto stopped = [&] { return source.stop && source.stop(); };
  progress(0, total, rays);

  struct Batch {
    std::vector<Subtree> subtrees;
    uint64_t rays = 0;
  };
  const auto hand_out = [&](tbb::flow_control& control) {
    const uint32_t first = next;
    if (first >= total || stopped()) control.stop();
    next += step;
    return first;
  };
  const auto classify = [&](uint32_t first) {
    Batch batch;
    Workspace& workspace = workspaces.local();
    for (uint32_t slot = first; slot < std::min(first + step, total); ++slot) {
      const Cell cell = top_cell(shape, slot);
      uint32_t value = ancestors[slot];
      if (value == kDeeper) value = source.classify(cell, workspace);
      batch.subtrees.push_back(classify_subtree(source, cell, value, workspace));
    }
    batch.rays = std::exchange(workspace.rays, 0);
    return batch;
  };
  const auto merge = [&](const Batch& batch) {
    for (const Subtree& subtree : batch.subtrees) dag.append(subtree);
    rays += batch.rays;
    done += static_cast<uint32_t>(batch.subtrees.size());
    progress(done, total, rays);
  };
  using tbb::filter_mode;
  tbb::parallel_pipeline(4 * static_cast<size_t>(tbb::this_task_arena::max_concurrency()),
                         tbb::make_filter<void, uint32_t>(filter_mode::serial_in_order, hand_out) &
                             tbb::make_filter<uint32_t, Batch>(filter_mode::parallel, classify) &
                             tbb::make_filter<Batch, void>(filter_mode::serial_in_order, merge));
  if (done < total || stopped()) return std::nullopt;
  return Octree{dag.take(), rays};
}

}  // namespace

std::optional<Octree> build_octree(const CellSource& source, unsigned threads, const OctreeProgress& progress) {
  return with_threads(threads, [&] { return build(source, progress); });
}

}  // namespace vcd::baker
