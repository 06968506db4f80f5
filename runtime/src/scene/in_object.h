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

// A segment in the frame of an instance's object; nothing where that frame cannot hold it.
inline std::optional<Segment> in_object(const SceneData& scene, uint32_t instance, const Segment& segment) noexcept {
  const ToGrid& grid = scene.to_grid[instance];
  const ToFrame& frame = scene.to_frame[instance];
  if (!has_inverse(grid)) return std::nullopt;
  return is_trusted(segment) ? in_frame(frame, in_grid(grid, segment)) : far_in_frame(grid, frame, segment);
}

// Whether the query names the triangle of `instance` that segment i of it begins on, and the horizons prove that the
// instance does not block the segment. A bundle has one triangle, i = 0.
inline bool clear_of_self(const SceneData& scene, const SceneQuery& query, size_t i, uint32_t instance,
                          const Segment& segment) noexcept {
  if (i >= query.primitives.size()) return false;
  const ObjectData* const object = scene.sidecars[instance];
  if (!object || !object->horizons.view) return false;
  const std::optional<Segment> moved = in_object(scene, instance, segment);
  return moved && clear_of_horizon(object->horizons.view, object->horizons.hierarchy, *moved, query.primitives[i]);
}

}  // namespace vcd
