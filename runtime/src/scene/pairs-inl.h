// Scenes of instances: a segment a time through the hierarchy, (segment, instance) pairs a lane through the trees.
#if defined(VCD_RUNTIME_SCENE_PAIRS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_SCENE_PAIRS_INL_H
#undef VCD_RUNTIME_SCENE_PAIRS_INL_H
#else
#define VCD_RUNTIME_SCENE_PAIRS_INL_H
#endif

#include <span>

#include "lookup/grids-inl.h"
#include "lookup/mask_bits-inl.h"
#include "scene/boxes.h"
#include "scene/pairs.h"
#include "scene/walk.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

using Boxes = hn::CappedTag<float, kBoxes>;

// A bit for each box that is entered, within rounding, before it is left.
HWY_INLINE uint32_t meet(hn::VFromD<Boxes> near, hn::VFromD<Boxes> far) {
  const auto slack = hn::Set(Boxes(), kBoxSlack);
  const auto hit = hn::Le(hn::Sub(near, hn::Mul(hn::Abs(near), slack)), hn::Add(far, hn::Mul(hn::Abs(far), slack)));
  return lane_bits(Boxes(), hit);
}

// Which of a node's boxes a segment could meet.
HWY_NOINLINE uint32_t BoxesMet(const SceneNode& node, const SceneRay& ray) {
  const auto all_boxes = [](float x) HWY_ATTR { return hn::Set(Boxes(), x); };
  uint32_t met = 0;
  for (size_t i = 0; i < kBoxes; i += hn::MaxLanes(Boxes())) {
    auto near = all_boxes(ray.t_min), far = all_boxes(ray.t_max);
    for (int a = 0; a < 3; ++a) {
      const auto origin = all_boxes(ray.origin[a]), inverse = all_boxes(ray.inverse[a]);
      near = hn::Max(near, hn::Mul(hn::Sub(hn::Load(Boxes(), node.side[ray.first[a]][a] + i), origin), inverse));
      far = hn::Min(far, hn::Mul(hn::Sub(hn::Load(Boxes(), node.side[ray.first[a] ^ 1][a] + i), origin), inverse));
    }
    met |= meet(near, far) << i;
  }
  return met;
}

// Which of a node's boxes a beam could meet.
HWY_NOINLINE uint32_t BoxesInBeam(const SceneNode& node, const SceneBeam& beam) noexcept {
  const auto all_boxes = [](float x) HWY_ATTR { return hn::Set(Boxes(), x); };
  uint32_t met = 0;
  for (size_t i = 0; i < kBoxes; i += hn::MaxLanes(Boxes())) {
    auto near = hn::Zero(Boxes()), far = all_boxes(beam.t_max);
    const auto bound = [&](auto offset, float inverse, bool first) HWY_ATTR {
      const auto t = hn::Mul(offset, all_boxes(inverse));
      if (first) near = hn::Max(near, t);
      else far = hn::Min(far, t);
    };
    for (int a = 0; a < 3; ++a) {
      bound(hn::Sub(hn::Load(Boxes(), node.side[1][a] + i), all_boxes(beam.origin_low[a])), beam.inverse_low[a],
            beam.inverse_low[a] < 0);
      bound(hn::Sub(hn::Load(Boxes(), node.side[0][a] + i), all_boxes(beam.origin_high[a])), beam.inverse_high[a],
            beam.inverse_high[a] > 0);
    }
    met |= meet(near, far) << i;
  }
  return met;
}

constexpr uint32_t word(Place place) { return static_cast<uint32_t>(place); }

// At most kWidth pairs, each instance in its own grid.
HWY_INLINE void classify_pairs(const SceneData& scene, std::span<const Segment> segments, const ScenePair* pairs,
                               size_t count, SceneAnswers answers) {
  const hn::FixedTag<float, 4> four;
  HWY_ALIGN Segment moved[kWidth] = {};  // in place of t, what rounding grows with
  HWY_ALIGN float t_min[kWidth] = {}, t_max[kWidth] = {};
  for (size_t k = 0; k < count; ++k) {
    const Segment& segment = segments[pairs[k].segment];
    const auto [origin, direction] = placed_parts(scene.instances[pairs[k].instance].to_grid, segment);
    hn::StoreU(origin, four, moved[k].origin);
    hn::StoreU(direction, four, moved[k].direction);
    t_min[k] = segment.t_min, t_max[k] = segment.t_max;
  }
  InGrid in;
  in.lanes = load(moved);
  in.fixed = hn::Add(in.lanes.t_min, norm(in.lanes.origin)), in.moving = in.lanes.t_max;
  in.lanes.t_min = hn::Load(F(), t_min), in.lanes.t_max = hn::Load(F(), t_max);
  const Lines lines = locate_placed(in);
  const Places places = places_of(in.lanes, lines);

  HWY_ALIGN uint32_t stuv[kWidth], face_pair[kWidth], place[kWidth], swapped[kWidth];
  HWY_ALIGN float length[kWidth], entry[kWidth], exit[kWidth];
  const auto select = [](Truth truth, Place yes, Words no)
                          HWY_ATTR { return hn::IfThenElse(hn::RebindMask(U(), truth), all(word(yes)), no); };
  const Words inside = select(places.pierces, Place::pierces, all(word(Place::ends_inside)));
  const Words known = select(places.outside, Place::outside, inside);
  hn::Store(select(hn::Not(places.valid), Place::doubtful, known), U(), place);
  hn::Store(hn::IfThenElseZero(hn::RebindMask(U(), lines.swapped), all(1u)), U(), swapped);
  hn::Store(lines.entry, F(), entry);
  hn::Store(lines.exit, F(), exit);
  hn::Store(lines.stuv, U(), stuv);
  hn::Store(lines.pair, U(), face_pair);
  hn::Store(hn::Mul(hn::Sub(lines.exit, lines.entry), norm(in.lanes.direction)), F(), length);
  for (size_t k = 0; k < count; ++k) {
    const LineCell line{true,
                        true,
                        face_pair[k],
                        stuv[k] >> 24,
                        stuv[k] >> 16 & 255,
                        stuv[k] >> 8 & 255,
                        stuv[k] & 255,
                        swapped[k] != 0,
                        entry[k],
                        exit[k]};
    const Place at = static_cast<Place>(place[k]);
    answers.take(pairs[k], pair_answer(scene.look_ups[pairs[k].instance], at, line, segments[pairs[k].segment]), at,
                 length[k]);
  }
}

void ClassifyScene(const SceneData& scene, std::span<const Segment> segments, const SceneQuery& query,
                   SceneAnswers answers) noexcept {
  ScenePair pairs[kWidth];
  size_t count = 0;
  walk_segments(scene, segments, query, answers, BoxesMet, [&](const ScenePair& pair) HWY_ATTR {
    pairs[count++] = pair;
    if (count < kWidth) return;
    classify_pairs(scene, segments, pairs, count, answers);
    count = 0;
  });
  if (count > 0) classify_pairs(scene, segments, pairs, count, answers);
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
