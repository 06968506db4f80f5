#include "lookup/scalar_kernels.h"

#include "hierarchy/fan.h"
#include "hierarchy/traced.h"
#include "horizon/above.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "beam/beam.h"
#include "lookup/grids.h"
#include "scene/boxes.h"
#include "scene/pairs.h"
#include "scene/trace.h"
#include "scene/walk.h"

namespace vcd {
namespace {

template <class Grid>
[[gnu::always_inline]] inline Visibility classify_in(const Grid& grid, const TreeView& tree, TreeShape shape,
                                                     const Segment& segment) {
  const LineCell line = grid.locate(segment);
  const Place place = place_of(line, segment.t_min, segment.t_max);
  return look_up(tree, shape, widened(place, tree.clearances, line, segment.t_min, segment.t_max), line);
}

template <uint32_t kDepth>
void segments_of(const GridFrame& frame, const TreeView& tree, std::span<const Segment> segments,
                 Visibility* answers) noexcept {
  for (size_t i = 0; i < segments.size(); ++i) answers[i] = classify(frame, tree, tree_shape(kDepth), segments[i]);
}

template <uint32_t kDepth, class Grid, class From>
void arrays_of(const From& from, const TreeView& tree, const SegmentArrays& segments, Visibility* answers) noexcept {
  for (size_t i = 0; i < segments.count; ++i)
    answers[i] = classify_in(Grid{from}, tree, tree_shape(kDepth), segment_at(segments, i));
}

template <class Bundle>
void bundle_of(const GridFrame& frame, const LookUp& look_up, const Bundle& bundle, uint64_t* blocked,
               uint64_t* unclassified) noexcept {
  for (size_t first = 0; first < bundle.size(); first += kChunk) {
    const size_t count = std::min(kChunk, bundle.size() - first);
    SampleAnswers answers;
    for (size_t i = 0; i < count; ++i)
      answers.set(i, classify(frame, *look_up.tree, look_up.tree->shape, segment_of(bundle, first + i)));
    answers.blocked.store(count, blocked + first / 64);
    answers.unclassified.store(count, unclassified + first / 64);
  }
}

void placed_bundle(const LookUp& look_up, const PlacedBundle& bundle, SampleAnswers& answers) noexcept {
  const auto& o = bundle.frame.origin;
  for (size_t i = 0; i < bundle.chunk.count; ++i) {
    if (!(bundle.live >> (i / kRun) & 1)) continue;
    const auto& d = bundle.directions;
    answers.set(i, classify_in(PlacedGrid{bundle.grid}, *look_up.tree, look_up.tree->shape,
                               {{o[0], o[1], o[2]}, 0.0f, {d[0][i], d[1][i], d[2][i]}, 1.0f}));
  }
}

void measure(BundleChunk& chunk) noexcept {
  const auto extent_of = [&](const float* values) {
    Extent extent{values[0], values[0]};
    for (size_t i = 0; i < chunk.count; ++i) {
      if (std::isnan(values[i])) return Extent::nan();
      extent = {std::min(extent.low, values[i]), std::max(extent.high, values[i])};
    }
    return extent;
  };
  chunk.u_extent = extent_of(chunk.u), chunk.v_extent = extent_of(chunk.v);
}

void to_object(const ToGrid& grid, const ToFrame& frame, const SegmentArrays& world, float* const (&origin)[3],
               float* const (&direction)[3]) noexcept {
  for (size_t i = 0; i < world.count; ++i) {
    const Segment s = in_frame(frame, placed(grid, segment_at(world, i)).in_grid);
    for (int a = 0; a < 3; ++a) origin[a][i] = s.origin[a], direction[a][i] = s.direction[a];
  }
}

void scene_segments(const SceneData& scene, std::span<const Segment> segments, const SceneQuery& query,
                    SceneAnswers answers) noexcept {
  walk_segments(scene, segments, query, answers, boxes_met, [&](const ScenePair& pair) {
    const Segment& segment = segments[pair.segment];
    const Located at = located(placed(scene.instances[pair.instance].to_grid, segment));
    const Place place = place_of(at.line, segment.t_min, segment.t_max);
    answers.take(pair, pair_answer(scene.look_ups[pair.instance], place, at.line, segment), place, at.length);
  });
}

bool one_looked_up(const Traced& object, const LookUpOne& look_up, const Segment& segment) noexcept {
  const Visibility answer = look_up.classify(look_up.frame, look_up.tree, segment);
  return answer == Visibility::unclassified ? occluded_scalar(object, segment) : answer == Visibility::blocked;
}

SampleBits without_none(const ReachBox&, const Segment*, const SampleBits& live) noexcept { return live; }

struct ScalarScene {
  static constexpr auto boxes_met = &vcd::boxes_met;
  static constexpr auto trace = &occluded_scalar;
  static bool blocks_trusted(const SceneData& scene, uint32_t instance, const Segment& segment, const Begin& begin,
                             bool look_up) {
    return blocks(scene, instance, segment, begin, look_up, trace);
  }
};

bool scene_one(const SceneData& scene, const Segment& segment, const SceneQuery& query) noexcept {
  return occluded_in_scene<ScalarScene>(scene, segment, begin_of(query, 0), query.mask);
}

SampleBits scene_array(const SceneData& scene, std::span<const Segment> segments, const SceneQuery& query) noexcept {
  SampleBits blocked{};
  for (size_t i = 0; i < segments.size(); ++i)
    blocked.set(i, occluded_in_scene<ScalarScene>(scene, segments[i], begin_of(query, i), query.mask));
  return blocked;
}

template <uint32_t... kDepths>
const Kernels& kernels_of(std::integer_sequence<uint32_t, kDepths...>) {
  static const Kernels kernels = {
      "scalar",
      {TreeKernels{&segments_of<kDepths + 1>, &arrays_of<kDepths + 1, OwnGrid, GridFrame>,
                   &arrays_of<kDepths + 1, PlacedGrid, ToGrid>}...},
      &bundle_of<QuadBundle>,
      &bundle_of<SphereBundle>,
      &scene_segments,
      &placed_bundle,
      &boxes_in_beam,
      &measure,
      &to_object,
      &scene_one,
      &scene_array,
      {&occluded_scalar, &one_looked_up, &occluded_array_scalar, &occluded_fan_scalar, &without_none},
      {&is_clear_scalar, &above_array_scalar, &above_fan_scalar}};
  return kernels;
}

}  // namespace

const Kernels& scalar_kernels() { return kernels_of(std::make_integer_sequence<uint32_t, kMaxDepth>()); }

}  // namespace vcd
