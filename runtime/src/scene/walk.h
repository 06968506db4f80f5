// The one way through the hierarchy over the instances.
#pragma once

#include <bit>
#include <span>

#include "scene/in_object.h"
#include "scene/pairs.h"
#include "scene/scene_data.h"
#include "scene/trusted.h"

namespace vcd {

// visit(instance) for the instances with a bit of `mask` whose boxes are met, until done(). boxes_met(node) gives a bit
// for each of a node's eight boxes.
template <class BoxesMet, class Done, class Visit>
void walk(const SceneData& scene, uint32_t mask, const BoxesMet& boxes_met, const Done& done, const Visit& visit) {
  uint32_t waiting[kDeepest];
  size_t count = 0;
  if (!scene.nodes.empty()) waiting[count++] = 0;
  while (count > 0 && !done()) {
    const SceneNode& node = scene.nodes[waiting[--count]];
    for (uint32_t met = boxes_met(node); met; met &= met - 1) {
      const uint32_t child = node.child[std::countr_zero(met)], instance = child & ~kLeaf;
      if (!(child & kLeaf)) waiting[count++] = child;
      else if (scene.masks[instance] & mask) visit(instance);
    }
  }
}

// Of a trusted segment.
inline SceneRay scene_ray(const Segment& segment) {
  SceneRay ray{{}, {}, segment.t_min, segment.t_max};
  for (int a = 0; a < 3; ++a) ray.origin[a] = segment.origin[a], ray.inverse[a] = inverse_of(segment.direction[a]);
  return ray;
}

// Leads segments through the hierarchy one by one. ask(pair) may answer at once or later.
template <class BoxesMet, class Ask>
void walk_segments(const SceneData& scene, std::span<const Segment> segments, const SceneQuery& query,
                   SceneAnswers answers, const BoxesMet& boxes_met, const Ask& ask) {
  for (uint32_t s = 0; s < segments.size() && !scene.nodes.empty(); ++s) {
    const Segment& segment = segments[s];
    if (!is_trusted(segment)) {
      answers.give_up(s);
      continue;
    }
    const SceneRay ray = scene_ray(segment);
    const uint32_t self = s < query.origins.size() ? query.origins[s] : kNoInstance;
    walk(
        scene, query.mask, [&](const SceneNode& node) { return boxes_met(node, ray); }, [&] { return answers.done(s); },
        [&](uint32_t instance) {
          if (instance != self) ask(ScenePair{s, instance});
          else if (!clear_of_self(scene, query, s, instance, segment))
            answers.take({s, instance}, Visibility::unclassified, Place::doubtful, kGrid);
        });
  }
}

}  // namespace vcd
