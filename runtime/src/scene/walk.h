// The one way through the hierarchy over the instances.
#pragma once

#include <bit>
#include <span>

#include "scene/in_object.h"
#include "scene/pairs.h"
#include "scene/scene_data.h"
#include "scene/trusted.h"

namespace vcd {

// A way through the hierarchy, depth first, that stops at each instance.
class SceneWalk {
 public:
  bool has_begun() const { return has_begun_; }

  // The next instance with a bit of `mask` whose box is met; kNoInstance after the last. boxes_met(node) gives a bit
  // for each of a node's boxes.
  template <class BoxesMet>
  uint32_t next(const SceneData& scene, uint32_t mask, const BoxesMet& boxes_met) {
    if (!has_begun_ && !scene.nodes.empty()) at_.met = boxes_met(scene.nodes[0]);
    has_begun_ = true;
    for (;;) {
      while (at_.met == 0) {
        if (levels_ == 0) return kNoInstance;
        at_ = above_[--levels_];
      }
      auto at = static_cast<uint32_t>(std::countr_zero(at_.met));
      const uint32_t* const children = scene.nodes[at_.node].child;
      const uint32_t child = children[at], instance = child & ~(kLeaf | kAgain);
      at_.met &= at_.met - 1;
      if (child & kLeaf) {
        while (children[at] & kAgain) at_.met &= ~(1u << ++at);  // its other boxes
        if (scene.instances[instance].mask & mask) return instance;
      } else {
        if (at_.met != 0) above_[levels_++] = at_;
        at_ = {child, boxes_met(scene.nodes[child])};
      }
    }
  }

 private:
  struct At {
    uint32_t node, met;  // and which of its boxes are still to be looked at
  };

  At at_{0, 0};
  bool has_begun_ = false;
  uint32_t levels_ = 0;
  At above_[kMostSceneLevels];
};

// visit(instance) for all of a SceneWalk, until done().
template <class BoxesMet, class Done, class Visit>
void walk(const SceneData& scene, uint32_t mask, const BoxesMet& boxes_met, const Done& done, const Visit& visit) {
  SceneWalk way;
  while (!done()) {
    const uint32_t instance = way.next(scene, mask, boxes_met);
    if (instance == kNoInstance) return;
    visit(instance);
  }
}

// Of a trusted segment.
inline SceneRay scene_ray(const Segment& segment) {
  SceneRay ray{{}, {}, segment.t_min, segment.t_max, {}};
  for (uint32_t a = 0; a < 3; ++a) {
    ray.origin[a] = segment.origin[a], ray.inverse[a] = inverse_of(segment.direction[a]);
    ray.first[a] = ray.inverse[a] < 0;
  }
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
