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

// Whether an instance blocks a segment. look_up: try that before the hierarchy. Horizons are asked first of the
// instance that the segment begins on. trace(object, segment) asks a hierarchy.
template <class Trace>
bool blocks(const SceneData& scene, uint32_t instance, const Segment& segment, const Begin& begin, bool look_up,
            const Trace& trace) {
  const ObjectData& object = traced_object(scene, instance);
  const std::optional<Segment> in = in_object(scene, instance, segment);
  if (!in) return blocks_in_world(object.traced.view, scene.to_world[instance], segment);
  if (instance == begin.instance && is_clear_scalar(object.horizons, *in, begin.primitive)) return false;
  if (look_up && is_trusted(segment)) {
    const Visibility answer = object.classify_placed(object.tree, placed(scene.instances[instance].to_grid, segment));
    if (answer != Visibility::unclassified) return answer == Visibility::blocked;
  }
  return trace(object.traced, *in);
}

// The instances that a segment may meet, one after another: its own comes first and is not looked up.
class Candidates {
 public:
  // The segment outlives this.
  Candidates(const Segment& segment, const Begin& begin, uint32_t mask)
      : segment_(&segment), begin_(begin), mask_(mask), self_is_next_(begin.instance != kNoInstance) {}
  const Begin& begin() const { return begin_; }

  // Of a trusted segment. kNoInstance after the last.
  template <class BoxesMet>
  uint32_t next(const SceneData& scene, const BoxesMet& boxes_met) {
    if (std::exchange(self_is_next_, false) && (scene.instances[begin_.instance].mask & mask_)) return begin_.instance;
    if (!way_.has_begun()) ray_ = scene_ray(*segment_);  // of many, their own instance is all that is asked
    for (;;) {
      const uint32_t instance = way_.next(scene, mask_, [&](const SceneNode& node) { return boxes_met(node, ray_); });
      if (instance == kNoInstance || instance != begin_.instance) return instance;
    }
  }
  bool looks_up(const SceneData& scene, uint32_t instance) const {
    return instance != begin_.instance && scene.instances[instance].look_up_one;
  }

 private:
  SceneWalk way_;
  const Segment* segment_;
  SceneRay ray_;
  Begin begin_;
  uint32_t mask_;
  bool self_is_next_;
};

// Whether some instance blocks the segment. Kernel has boxes_met(node, ray), trace() for blocks(), and
// blocks_trusted(scene, instance, segment, begin, look_up), which says what blocks() does of a trusted segment.
template <class Kernel>
bool occluded_in_scene(const SceneData& scene, const Segment& segment, const Begin& begin, uint32_t mask) {
  if (!is_trusted(segment)) {
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
      if ((scene.instances[i].mask & mask) && blocks(scene, i, segment, begin, false, Kernel::trace)) return true;
    return false;
  }
  Candidates candidates(segment, begin, mask);
  for (;;) {
    const uint32_t instance = candidates.next(scene, Kernel::boxes_met);
    if (instance == kNoInstance) return false;
    if (Kernel::blocks_trusted(scene, instance, segment, begin, candidates.looks_up(scene, instance))) return true;
  }
}

}  // namespace vcd
