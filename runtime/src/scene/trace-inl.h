// Segments through a scene: single ones, and arrays.
#if defined(VCD_RUNTIME_SCENE_TRACE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_SCENE_TRACE_INL_H
#undef VCD_RUNTIME_SCENE_TRACE_INL_H
#else
#define VCD_RUNTIME_SCENE_TRACE_INL_H
#endif

#include <array>
#include <optional>

#include "hierarchy/array-inl.h"
#include "hierarchy/trace-inl.h"
#include "horizon/above-inl.h"
#include "lookup/grids-inl.h"
#include "scene/pairs-inl.h"
#include "scene/trace.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

// A trusted segment in the grid and in the frame of an instance's object.
struct Moved {
  PlacedSegment placed;
  Segment segment;
};

// What placed() and in_frame() say.
HWY_INLINE Moved moved_to(const ToGrid& grid, const ToFrame& frame, const Segment& world) {
  const hn::FixedTag<float, 4> d;
  const auto three = hn::FirstN(d, 3);
  const auto unit = hn::Load(d, frame.unit), given_origin = hn::LoadU(d, world.origin),
             given_direction = hn::LoadU(d, world.direction);  // and t in the fourth lanes
  const auto [origin, direction] = placed_parts(grid, world);  // and what rounding grows with
  Moved moved;
  hn::StoreU(hn::IfThenElse(three, origin, given_origin), d, moved.placed.in_grid.origin);
  hn::StoreU(hn::IfThenElse(three, direction, given_direction), d, moved.placed.in_grid.direction);
  moved.placed.fixed = hn::ExtractLane(origin, 3), moved.placed.moving = hn::ExtractLane(direction, 3);
  hn::StoreU(hn::IfThenElse(three, hn::Add(hn::Mul(origin, unit), hn::Load(d, frame.min)), given_origin), d,
             moved.segment.origin);
  hn::StoreU(hn::IfThenElse(three, hn::Mul(direction, unit), given_direction), d, moved.segment.direction);
  return moved;
}

// What is to be asked of a trusted segment and an instance.
struct Entered {
  const ObjectData* object;  // null: `blocked` is the answer
  bool blocked;
};

// The first half of blocks(), up to the look-up.
HWY_INLINE Entered enter(const SceneData& scene, uint32_t instance, const Segment& segment, const Begin& begin,
                         Moved& moved) {
  const ObjectData& object = traced_object(scene, instance);
  const ToGrid& grid = scene.instances[instance].to_grid;
  if (HWY_UNLIKELY(!has_inverse(grid)))
    return {nullptr, blocks_in_world(object.traced.view, scene.to_world[instance], segment)};
  moved = moved_to(grid, scene.instances[instance].to_frame, segment);
  if (instance == begin.instance && is_clear(object.horizons, moved.segment, begin.primitive)) return {nullptr, false};
  return {&object, false};
}

// Says what blocks() says.
bool BlocksTrusted(const SceneData& scene, uint32_t instance, const Segment& segment, const Begin& begin,
                   bool look_up) noexcept {
  Moved moved;
  const Entered entered = enter(scene, instance, segment, begin, moved);
  if (!entered.object) return entered.blocked;
  const ObjectData& object = *entered.object;
  const auto looked_up = [&](bool now) {
    return now ? object.classify_placed(object.tree, moved.placed) : Visibility::unclassified;
  };
  if (const Visibility answer = looked_up(look_up && !object.box_first); answer != Visibility::unclassified)
    return answer == Visibility::blocked;
  NearRay ray;
  const Nearness nearness = make_near_ray(object.traced, moved.segment, ray);
  if (nearness == Nearness::misses) return false;
  if (const Visibility answer = looked_up(look_up && object.box_first); answer != Visibility::unclassified)
    return answer == Visibility::blocked;
  return nearness == Nearness::far ? occluded_scalar(object.traced, moved.segment)
                                   : trace_from(object.traced.view, kRootUnit, ray, moved.segment);
}

struct SceneKernel {
  static constexpr auto boxes_met = &BoxesMet;
  static constexpr auto trace = &Occluded;
  static constexpr auto blocks_trusted = &BlocksTrusted;
};

bool OccludedInScene(const SceneData& scene, const Segment& segment, const SceneQuery& query) noexcept {
  return occluded_in_scene<SceneKernel>(scene, segment, begin_of(query, 0), query.mask);
}

// A segment is asked of one instance after another.
class SceneSource {
 public:
  static constexpr bool kOneObject = false;

  SceneSource(const SceneData& scene, std::span<const Segment> segments, const SceneQuery& query)
      : scene_(scene), segments_(segments), query_(query) {}

  HWY_INLINE bool begin(uint8_t k, uint32_t index) {
    const Segment& segment = segments_[index];
    const Begin begins = begin_of(query_, index);
    from_[k] = &segment;
    if (is_trusted(segment)) return candidates_[k].emplace(segment, begins, query_.mask), true;
    candidates_[k].reset();
    return !occluded_in_scene<SceneKernel>(scene_, segment, begins, query_.mask);
  }
  HWY_INLINE Next next(uint8_t k, Segment& segment) {
    if (!candidates_[k]) return {nullptr, false};
    for (;;) {
      const uint32_t instance = candidates_[k]->next(scene_, BoxesMet);
      if (instance == kNoInstance) return {nullptr, false};
      Moved moved;
      const auto [object, blocked] = enter(scene_, instance, *from_[k], candidates_[k]->begin(), moved);
      if (blocked) return {nullptr, true};
      if (!object) continue;
      if (candidates_[k]->looks_up(scene_, instance)) {
        const Visibility answer = object->classify_placed(object->tree, moved.placed);
        if (answer == Visibility::blocked) return {nullptr, true};
        if (answer == Visibility::clear) continue;
      }
      segment = moved.segment;
      return {&object->traced, false};
    }
  }

 private:
  const SceneData& scene_;
  std::span<const Segment> segments_;
  const SceneQuery& query_;
  std::array<std::optional<Candidates>, kFlights> candidates_;  // none: the segment is not trusted, and was answered
  const Segment* from_[kFlights];
};

SampleBits OccludedArrayInScene(const SceneData& scene, std::span<const Segment> segments,
                                const SceneQuery& query) noexcept {
  const SampleBits live = WithoutPassing(scene.box, segments.data(), SampleBits::first(segments.size()));
  SceneSource source(scene, segments, query);
  return Stream(source).blocked(live);
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
