#include <vcd/baker/measure.h>

#include <cassert>
#include <chrono>
#include <utility>

#include "classify/make_classifier.h"
#include "measure/thinned_cells.h"
#include "object/baked_object.h"
#include "octree/octree.h"

namespace vcd::baker {

Result<BakeTime> time_bake(const PreparedMesh& mesh, const BakeOptions& options, uint32_t one_in) {
  assert(options.method != Method::none && options.depth >= kMinDepth && options.depth <= kMaxDepth && one_in > 0);
  const GridMesh grid(mesh);
  const auto tracer = trace_in_grid(grid);
  if (!tracer) return tracer.error();
  const ChosenClassifier classifier = make_classifier(grid, *tracer, options);
  const ThinnedCells thinned(*classifier.cells, options.depth, one_in);
  CellSource source{thinned, options.depth};
  source.stop = options.stop;

  using Clock = std::chrono::steady_clock;
  const auto seconds = [](Clock::duration time) { return std::chrono::duration<double>(time).count(); };
  const auto start = Clock::now();
  const auto octree = build_octree(source, options.threads, [](uint64_t, uint64_t, uint64_t) {});
  if (!octree) return Error{ErrorCode::runtime, "stopped"};
  const auto end = Clock::now();
  return BakeTime{seconds(thinned.top_reached_at() - start) + one_in * seconds(end - thinned.top_reached_at()),
                  octree->rays};
}

BakedObject make_unclassified_object(const PreparedMesh& mesh, uint32_t depth) {
  assert(depth >= kMinDepth && depth <= kMaxDepth);
  TreeArrays tree = unclassified_tree(depth);
  const TreeStatistics counts = measure_tree(tree.view());
  return make_object(mesh, {Method::sampled, depth, kDefaultSamples, 0}, counts, {std::move(tree), {}, {}});
}

}  // namespace vcd::baker
