// Segments of the world in the frame of an instance's object, and what its horizons say of those that begin on it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "lookup/grids.h"
#include "lookup/object_data.h"
#include "scene/scene_data.h"
#include "scene/trusted.h"

namespace vcd {

// The object of an instance that is to be traced.
inline const ObjectData& traced_object(const SceneData& scene, uint32_t instance) noexcept {
  const ObjectData* const object = scene.instances[instance].object;
  if (!object || !object->traced.view) fail_without_hierarchy();
  return *object;
}

// A segment in the frame of an instance's object; nothing where that frame cannot hold it.
inline std::optional<Segment> in_object(const SceneData& scene, uint32_t instance, const Segment& segment) noexcept {
  const ToGrid& grid = scene.instances[instance].to_grid;
  const ToFrame& frame = scene.instances[instance].to_frame;
  if (!has_inverse(grid)) return std::nullopt;
  return is_trusted(segment) ? in_frame(frame, placed(grid, segment).in_grid) : far_in_frame(grid, frame, segment);
}

// Where a segment of a query begins.
struct Begin {
  uint32_t instance = kNoInstance, primitive = kNoPrimitive;
};
inline Begin begin_of(const SceneQuery& query, size_t i) {
  return {i < query.origins.size() ? query.origins[i] : kNoInstance,
          i < query.primitives.size() ? query.primitives[i] : kNoPrimitive};
}

// Whether horizons prove that the instance that the segment begins on does not block it.
inline bool clear_of_self(const SceneData& scene, const Begin& begin, const Segment& segment) noexcept {
  if (begin.primitive == kNoPrimitive) return false;
  const ObjectData* const object = scene.instances[begin.instance].object;
  if (!object || !object->horizons.view) return false;
  const std::optional<Segment> moved = in_object(scene, begin.instance, segment);
  return moved && object->horizon->one(object->horizons, *moved, begin.primitive);
}

}  // namespace vcd
