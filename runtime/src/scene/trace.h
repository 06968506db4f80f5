// Instances traced through their objects' hierarchies.
#pragma once

#include <cstdint>
#include <optional>

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

// Whether the instance blocks the segment. trace(object, segment) asks its hierarchy.
template <class Trace>
bool blocks(const SceneData& scene, uint32_t instance, const Segment& segment, bool look_up, const Trace& trace) {
  const ObjectData* const object = scene.sidecars[instance];
  if (!object || !object->traced.view) fail_without_hierarchy();
  const std::optional<Segment> moved = in_object(scene, instance, segment);
  if (!moved) return blocks_in_world(object->traced.view, scene.to_world[instance], segment);
  if (look_up && scene.objects[instance].tree && is_trusted(segment)) {
    const Located at = PlacedGrid{scene.to_grid[instance]}.locate_with_length(segment);
    const Place place = place_of(at.line, segment.t_min, segment.t_max);
    const Visibility answer = pair_answer(scene.objects[instance], place, at.line, segment);
    if (answer != Visibility::unclassified) return answer == Visibility::blocked;
  }
  return trace(object->traced, *moved);
}

// Whether some instance blocks the segment; its own is asked first.
template <class BoxesMet, class Trace>
bool occluded_in_scene(const SceneData& scene, const Segment& segment, const SceneQuery& query,
                       const BoxesMet& boxes_met, const Trace& trace) {
  const uint32_t self = query.origins.empty() ? kNoInstance : query.origins[0];
  if (self != kNoInstance && (scene.masks[self] & query.mask) && !clear_of_self(scene, query, 0, self, segment) &&
      blocks(scene, self, segment, false, trace))
    return true;
  bool blocked = false;
  const auto ask = [&](uint32_t instance) {
    if (instance != self && !blocked)
      blocked = blocks(scene, instance, segment, scene.look_up_first[instance] != 0, trace);
  };
  if (!is_trusted(segment)) {
    for (uint32_t i = 0; i < scene.masks.size(); ++i)
      if (scene.masks[i] & query.mask) ask(i);
    return blocked;
  }
  const SceneRay ray = scene_ray(segment);
  walk(
      scene, query.mask, [&](const SceneNode& node) { return boxes_met(node, ray); }, [&] { return blocked; }, ask);
  return blocked;
}

}  // namespace vcd
