// Instances traced through their objects' hierarchies.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "hierarchy/traced.h"
#include "lookup/grids.h"
#include "lookup/object_data.h"
#include "scene/in_object.h"
#include "scene/pairs.h"
#include "scene/scene_data.h"
#include "scene/trusted.h"
#include "scene/walk.h"

namespace vcd {

// Whether a triangle of the instance, its corners moved into the world and rounded there, meets the segment. Looks at
// all of them: for flat transforms, and for what floats hold in the world alone.
bool blocks_in_world(const HierarchyView& view, const Transform& to_world, const Segment& segment) noexcept;

// What is left of a segment and an instance after all but the hierarchy was asked.
struct Entered {
  const Traced* object;  // null: `blocked` is the answer
  bool blocked;
};

// Moves the segment into the object's frame, where `moved` is what the hierarchy is to be asked of. look_up: try that
// first. Horizons are asked first of the instance that it begins on.
inline Entered enter(const SceneData& scene, uint32_t instance, const Segment& segment, const Begin& begin,
                     bool look_up, Segment& moved) {
  const ObjectData& object = traced_object(scene, instance);
  const std::optional<Segment> in = in_object(scene, instance, segment);
  if (!in) return {nullptr, blocks_in_world(object.traced.view, scene.to_world[instance], segment)};
  if (instance == begin.instance && is_clear(object.horizons, *in, begin.primitive)) return {nullptr, false};
  if (look_up && scene.objects[instance].tree && is_trusted(segment)) {
    const Located at = PlacedGrid{scene.to_grid[instance]}.locate_with_length(segment);
    const Place place = place_of(at.line, segment.t_min, segment.t_max);
    const Visibility answer = pair_answer(scene.objects[instance], place, at.line, segment);
    if (answer != Visibility::unclassified) return {nullptr, answer == Visibility::blocked};
  }
  moved = *in;
  return {&object.traced, false};
}

// The instances that a segment may meet, one after another: its own comes first and is not looked up.
class Candidates {
 public:
  Candidates(const SceneData& scene, const Segment& segment, const Begin& begin, uint32_t mask)
      : way_(scene),
        ray_(scene_ray(segment)),
        begin_(begin),
        mask_(mask),
        self_is_next_(begin.instance != kNoInstance) {}
  const Begin& begin() const { return begin_; }

  // Of a trusted segment. kNoInstance after the last.
  template <class BoxesMet>
  uint32_t next(const SceneData& scene, const BoxesMet& boxes_met) {
    if (std::exchange(self_is_next_, false) && (scene.masks[begin_.instance] & mask_)) return begin_.instance;
    for (;;) {
      const uint32_t instance = way_.next(scene, mask_, [&](const SceneNode& node) { return boxes_met(node, ray_); });
      if (instance == kNoInstance || instance != begin_.instance) return instance;
    }
  }
  bool looks_up(const SceneData& scene, uint32_t instance) const {
    return instance != begin_.instance && scene.look_up_first[instance] != 0;
  }

 private:
  SceneWalk way_;
  SceneRay ray_;
  Begin begin_;
  uint32_t mask_;
  bool self_is_next_;
};

// Whether some instance blocks the segment. trace(object, segment) asks a hierarchy.
template <class BoxesMet, class Trace>
bool occluded_in_scene(const SceneData& scene, const Segment& segment, const Begin& begin, uint32_t mask,
                       const BoxesMet& boxes_met, const Trace& trace) {
  const auto blocks = [&](uint32_t instance, bool look_up) {
    Segment moved;
    const Entered entered = enter(scene, instance, segment, begin, look_up, moved);
    return entered.object ? trace(*entered.object, moved) : entered.blocked;
  };
  if (!is_trusted(segment)) {
    for (uint32_t i = 0; i < scene.masks.size(); ++i)
      if ((scene.masks[i] & mask) && blocks(i, false)) return true;
    return false;
  }
  Candidates candidates(scene, segment, begin, mask);
  for (;;) {
    const uint32_t instance = candidates.next(scene, boxes_met);
    if (instance == kNoInstance) return false;
    if (blocks(instance, candidates.looks_up(scene, instance))) return true;
  }
}

// The same for at most kChunk segments, one after another: those of `live` that are blocked.
template <class BoxesMet, class Trace>
SampleBits occluded_array_in_scene(const SceneData& scene, std::span<const Segment> segments, const SceneQuery& query,
                                   const SampleBits& live, const BoxesMet& boxes_met, const Trace& trace) {
  SampleBits blocked{};
  for (size_t i : live)
    blocked.set(i, occluded_in_scene(scene, segments[i], begin_of(query, i), query.mask, boxes_met, trace));
  return blocked;
}

}  // namespace vcd
