// The one way through the hierarchy over the instances.
#pragma once

#include <bit>
#include <span>

#include "scene/in_object.h"
#include "scene/pairs.h"
#include "scene/scene_data.h"
#include "scene/trusted.h"

namespace vcd {

// A way through the hierarchy that stops at each instance.
class SceneWalk {
 public:
  explicit SceneWalk(const SceneData& scene) : count_(scene.nodes.empty() ? 0 : 1) { waiting_[0] = 0; }

  // The next instance with a bit of `mask` whose box is met; kNoInstance after the last. boxes_met(node) gives a bit
  // for each of a node's eight boxes.
  template <class BoxesMet>
  uint32_t next(const SceneData& scene, uint32_t mask, const BoxesMet& boxes_met) {
    for (;;) {
      while (met_ != 0) {
        const uint32_t child = scene.nodes[node_].child[std::countr_zero(met_)], instance = child & ~kLeaf;
        met_ &= met_ - 1;
        if (!(child & kLeaf)) waiting_[count_++] = child;
        else if (scene.masks[instance] & mask) return instance;
      }
      if (count_ == 0) return kNoInstance;
      node_ = waiting_[--count_];
      met_ = boxes_met(scene.nodes[node_]);
    }
  }

 private:
  uint32_t node_ = 0, met_ = 0;  // and which of its boxes are still to be looked at
  uint32_t count_;
  uint32_t waiting_[kDeepest];
};

// visit(instance) for all of a SceneWalk, until done().
template <class BoxesMet, class Done, class Visit>
void walk(const SceneData& scene, uint32_t mask, const BoxesMet& boxes_met, const Done& done, const Visit& visit) {
  SceneWalk way(scene);
  while (!done()) {
    const uint32_t instance = way.next(scene, mask, boxes_met);
    if (instance == kNoInstance) return;
    visit(instance);
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
    const Begin begin = begin_of(query, s);
    walk(
        scene, query.mask, [&](const SceneNode& node) { return boxes_met(node, ray); }, [&] { return answers.done(s); },
        [&](uint32_t instance) {
          if (instance != begin.instance) ask(ScenePair{s, instance});
          else if (!clear_of_self(scene, begin, segment))
            answers.take({s, instance}, Visibility::unclassified, Place::doubtful, kGrid);
        });
  }
}

}  // namespace vcd
