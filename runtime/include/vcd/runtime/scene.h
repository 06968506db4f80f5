// Scenes of instances: one question for all of them.
//
//   auto scene = vcd::Scene::build(instances);
//   bool dark = scene->occluded(segment, [&](uint32_t instance) { return my_bvh_occluded(instance, segment); });
//
// A hierarchy over the instances' boxes finds those that a segment could meet; their sidecars are asked, many in one step;
// one blocked answer ends the segment; what is left goes to the caller.
//
// Threads: queries may run on any number of threads at once; set_transforms() not beside them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <vcd/runtime/sidecar.h>

namespace vcd {

// Row-major 3 × 4: world = rows · (object, 1).
struct Transform {
  float rows[3][4];
};

struct SceneInstance {
  std::optional<Object> object;  // none: always left to the caller where a segment could meet its box
  float box_min[3], box_max[3];  // that holds the mesh, in the object's own frame: the record's, if there is an object
  Transform to_world;
  uint32_t mask = 0xFFFFFFFF;    // asked where it shares a bit with the query's

  static SceneInstance of(Object object, const Transform& to_world);
};

// What a segment could still meet.
struct OpenPair {
  uint32_t segment;   // index in the query's array
  uint32_t instance;
  float length;       // of the segment's line inside the instance's box, in 256ths of the box
};

struct SceneQuery {
  uint32_t mask = 0xFFFFFFFF;
  // The instance that each segment begins on, or kNoInstance; empty if unknown. It is left to the caller without a look-up,
  // since from inside a box a look-up seldom answers.
  std::span<const uint32_t> origins = {};
};
inline constexpr uint32_t kNoInstance = 0xFFFFFFFF;

class Scene {
 public:
  // Instances keep their indices. Errors: usage (a transform that is not finite or cannot be inverted, a box that is empty
  // or not finite), with the index; an unknown kernel; runtime (out of memory).
  // kernel: one of kernels(); empty: the fastest.
  static Result<Scene> build(std::span<const SceneInstance> instances, const std::string& kernel = {});

  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;
  ~Scene();

  size_t size() const noexcept;

  // New transforms for all instances. Errors as build(); then nothing has changed.
  std::optional<Error> set_transforms(std::span<const Transform> to_world);

  // blocked: by some instance. clear: no instance meets the segment. Everything else is unclassified. What instances promise
  // holds in the world: see spec/design.md, "Scenes".
  Visibility classify(const Segment& segment, const SceneQuery& query = {}) const noexcept;
  void classify(std::span<const Segment> segments, std::span<Visibility> answers, const SceneQuery& query = {}) const noexcept;

  // The same, and for unclassified segments the instances that could meet them, by segment and then the longest first.
  struct Open {
    size_t count;   // of `open`, from its beginning
    bool complete;  // false: there was no room for all of them, or a segment is not finite and could meet any
  };
  Open classify(std::span<const Segment> segments, std::span<Visibility> answers, std::span<OpenPair> open,
                  const SceneQuery& query = {}) const noexcept;

  // Whether the segment is blocked. fallback(instance) -> bool is asked for instances that could meet it, until one does.
  template <class Fallback>
  bool occluded(const Segment& segment, Fallback&& fallback, const SceneQuery& query = {}) const {
    std::array<OpenPair, kMostOpen> open;
    Visibility answer;
    const auto [count, complete] = classify(std::span(&segment, 1), std::span(&answer, 1), open, query);
    if (answer != Visibility::unclassified) return answer == Visibility::blocked;
    for (size_t i = 0; i < count; ++i)
      if (fallback(open[i].instance)) return true;
    if (complete) return false;
    for (uint32_t i = 0; i < size(); ++i)
      if ((mask(i) & query.mask) != 0 && fallback(i)) return true;
    return false;
  }

 private:
  static constexpr size_t kMostOpen = 64;
  struct State;
  explicit Scene(std::unique_ptr<State> state);
  uint32_t mask(uint32_t instance) const noexcept;
  std::unique_ptr<State> state_;
};

}  // namespace vcd
