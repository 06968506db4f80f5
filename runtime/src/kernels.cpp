#include "kernels.h"

// Three kinds of x86-64 are enough: SSE4, AVX2 and AVX-512.
#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS HWY_SSSE3
#endif

// This file and what it includes are compiled once for each kind of processor.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "beam.h"
#include "bits.h"
#include "object_data.h"
#include "scene_data.h"

#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128  // single calls are faster than these
#include "arrays-inl.h"
#include "bundles-inl.h"
#include "scene-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

template <uint32_t... kDepths>
Kernels kernels_of(std::integer_sequence<uint32_t, kDepths...>) {
  return {hwy::TargetName(HWY_TARGET),
          {ManyKernels{&ClassifySegmentsOf<kDepths + 1>, &ClassifyArraysOf<kDepths + 1>, &ClassifyPlacedOf<kDepths + 1>,
                       &ClassifyBundleOf<QuadBundle>, &ClassifyBundleOf<SphereBundle>}...},
          {&ClassifySceneOf, &BoxesInBeam, &MeasureChunk, &ClassifyBundleIn, &ToObject}};
}
Kernels MakeKernels() { return kernels_of(std::make_integer_sequence<uint32_t, kMaxDepth>()); }

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif

#if HWY_ONCE
namespace vcd {
namespace {

// One segment after the other.
template <uint32_t kDepth>
void segments_of(const ObjectData& data, std::span<const Segment> segments, Visibility* answers) {
  for (size_t i = 0; i < segments.size(); ++i)
    answers[i] = classify(data.frame, data.tree, tree_shape(kDepth), segments[i]);
}
template <uint32_t kDepth>
void arrays_of(const ObjectData& data, const SegmentArrays& segments, Visibility* answers) {
  for (size_t i = 0; i < segments.count; ++i)
    answers[i] = classify(data.frame, data.tree, tree_shape(kDepth), segment_at(segments, i));
}
template <uint32_t kDepth, class Bundle>
void bundle_of(const ObjectData& data, const Bundle& bundle, uint64_t* blocked, uint64_t* open) {
  clear_bits(bundle.size(), blocked, open);
  for (size_t i = 0; i < bundle.size(); ++i)
    set_bits(classify(data.frame, data.tree, tree_shape(kDepth), segment_of(bundle, i)), i, blocked, open);
}
uint32_t boxes_met(const SceneNode& node, const SceneRay& ray) {
  uint32_t met = 0;
  for (int i = 0; i < 8; ++i) {
    float near = ray.t_min, far = ray.t_max;
    for (int a = 0; a < 3; ++a) {
      const bool turned = ray.inverse[a] < 0;
      near = std::max(near, ((turned ? node.high : node.low)[a][i] - ray.origin[a]) * ray.inverse[a]);
      far = std::min(far, ((turned ? node.low : node.high)[a][i] - ray.origin[a]) * ray.inverse[a]);
    }
    met |= uint32_t{near - std::abs(near) * kBoxSlack <= far + std::abs(far) * kBoxSlack} << i;
  }
  return met;
}

uint32_t boxes_in_beam(const SceneNode& node, const SceneBeam& beam) {
  uint32_t met = 0;
  for (int i = 0; i < 8; ++i) {
    float near = 0, far = beam.t_max;
    for (int a = 0; a < 3; ++a) {
      const float low = (node.high[a][i] - beam.origin_low[a]) * beam.inverse_low[a];
      const float high = (node.low[a][i] - beam.origin_high[a]) * beam.inverse_high[a];
      (beam.inverse_low[a] < 0 ? near : far) = beam.inverse_low[a] < 0 ? std::max(near, low) : std::min(far, low);
      (beam.inverse_high[a] > 0 ? near : far) = beam.inverse_high[a] > 0 ? std::max(near, high) : std::min(far, high);
    }
    met |= uint32_t{near - std::abs(near) * kBoxSlack <= far + std::abs(far) * kBoxSlack} << i;
  }
  return met;
}

// A segment in an instance's grid, and where it lies there.
struct Placed {
  PairPlace place;
  LineCell line;
  float length;
};
Placed placed(const ToGrid& grid, const Segment& segment) {
  const Segment in = in_grid(grid, segment);
  const float *d = segment.direction, o[3] = {segment.origin[0] - grid.centre[0], segment.origin[1] - grid.centre[1],
                                              segment.origin[2] - grid.centre[2]};
  constexpr GridFrame kGridItself = {{0, 0, 0, 0}, {1, 1, 1, 0}};
  const LineCell line = locate(kGridItself, in);
  const auto weighted = [&](const float* x) {
    return (grid.column[0][3] * std::abs(x[0]) + grid.column[1][3] * std::abs(x[1])) +
           grid.column[2][3] * std::abs(x[2]);
  };
  const auto norm = [](const float* x) { return (std::abs(x[0]) + std::abs(x[1])) + std::abs(x[2]); };
  const float reach =
      (weighted(o) + norm(in.origin)) + std::max(std::abs(line.t_entry), std::abs(line.t_exit)) * weighted(d);
  PairPlace place = PairPlace::unknown;
  if (line.valid && reach <= kFarthestReach) {
    const bool outside = !line.hits || segment.t_min >= line.t_exit || segment.t_max <= line.t_entry;
    const bool pierces = segment.t_min <= line.t_entry && segment.t_max >= line.t_exit;
    place = outside ? PairPlace::outside : pierces ? PairPlace::pierces : PairPlace::ends_inside;
  }
  return {place, line, (line.t_exit - line.t_entry) * norm(in.direction)};
}

void classify_pair(const SceneData& scene, const Segment& segment, const ScenePair& pair, SceneAnswers answers) {
  const Placed p = placed(scene.to_grid[pair.instance], segment);
  answers.take(pair, pair_answer(scene.objects[pair.instance], p.place, p.line, segment.t_min, segment.t_max),
               p.length);
}

template <uint32_t kDepth>
void placed_of(const ObjectData& data, const ToGrid& grid, const SegmentArrays& segments, Visibility* answers) {
  for (size_t i = 0; i < segments.count; ++i) {
    const Placed p = placed(grid, segment_at(segments, i));
    answers[i] = pair_answer(&data, p.place, p.line, segments.t_min[i], segments.t_max[i]);
  }
}

void measure(BundleChunk& chunk) {
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

void bundle_in(const ObjectData& data, const ToGrid& grid, const BeamFrame& frame, const BundleChunk& chunk,
               uint32_t live, const float* const (&directions)[3], uint64_t* blocked, uint64_t* open) {
  for (size_t i = 0; i < chunk.count; ++i) {
    if (!(live >> (i / kRun) & 1)) continue;
    const auto& o = frame.origin;
    const Placed p =
        placed(grid, {{o[0], o[1], o[2]}, 0.0f, {directions[0][i], directions[1][i], directions[2][i]}, 1.0f});
    set_bits(pair_answer(&data, p.place, p.line, 0.0f, 1.0f), i, blocked, open);
  }
}

void to_object(const ToGrid& grid, const ToFrame& frame, const SegmentArrays& world, float* const (&origin)[3],
               float* const (&direction)[3]) {
  for (size_t i = 0; i < world.count; ++i) {
    const Segment s = in_grid(grid, segment_at(world, i));
    for (int a = 0; a < 3; ++a) {
      origin[a][i] = s.origin[a] * frame.unit[a] + frame.min[a];
      direction[a][i] = s.direction[a] * frame.unit[a];
    }
  }
}

void scene_one_by_one(const SceneData& scene, std::span<const Segment> segments, const SceneQuery& query,
                      SceneAnswers answers) {
  walk_scene(scene, segments, query, answers, boxes_met,
             [&](const ScenePair& pair) { classify_pair(scene, segments[pair.segment], pair, answers); });
}

template <uint32_t... kDepths>
Kernels scalar_kernels(std::integer_sequence<uint32_t, kDepths...>) {
  return {"scalar",
          {ManyKernels{&segments_of<kDepths + 1>, &arrays_of<kDepths + 1>, &placed_of<kDepths + 1>,
                       &bundle_of<kDepths + 1, QuadBundle>, &bundle_of<kDepths + 1, SphereBundle>}...},
          {&scene_one_by_one, &boxes_in_beam, &measure, &bundle_in, &to_object}};
}

}  // namespace

std::vector<Kernels> usable_kernels() {
  std::vector<Kernels> usable;
  [[maybe_unused]] const int64_t supported = hwy::SupportedTargets();
#if HWY_TARGETS & HWY_AVX3
  if (supported & HWY_AVX3) usable.push_back(N_AVX3::MakeKernels());
#endif
#if HWY_TARGETS & HWY_AVX2
  if (supported & HWY_AVX2) usable.push_back(N_AVX2::MakeKernels());
#endif
#if HWY_TARGETS & HWY_SSE4
  if (supported & HWY_SSE4) usable.push_back(N_SSE4::MakeKernels());
#endif
#if HWY_TARGETS & HWY_NEON
  if (supported & HWY_NEON) usable.push_back(N_NEON::MakeKernels());
#endif
  usable.push_back(scalar_kernels(std::make_integer_sequence<uint32_t, kMaxDepth>()));
  return usable;
}

bool fits_gathers(const TreeView& tree) {
  constexpr uint64_t kMostWords = uint64_t{1} << 31;
  return tree.block256_count < kMostWords / kBlock256Words && tree.block16_count < kMostWords / kBlock16Words &&
         tree.brick_count < kMostWords / (kBrickBytes / 4);
}

}  // namespace vcd
#endif
