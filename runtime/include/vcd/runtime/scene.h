// Scenes of instances: one question for all of them.
//
//   auto scene = vcd::Scene::build(instances);
//   bool dark = scene->occluded(segment, [&](uint32_t instance) { return my_bvh_occluded(instance, segment); });
//
// A hierarchy over the instances' boxes finds those that a segment could meet; their sidecars are asked, many in one
// step; one blocked answer ends the segment; what is left goes to the caller.
//
// Transforms, boxes and segments may hold any floats. An instance that cannot be looked up is left to the caller, and
// does not stop the scene from being built: Scene::use() says which are so.
//
// Threads: queries may run on any number of threads at once; set_transforms() not beside them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include <vcd/runtime/bundle.h>
#include <vcd/runtime/segment_arrays.h>
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
  uint32_t mask = 0xFFFFFFFF;  // asked where it shares a bit with the query's

  static SceneInstance of(Object object, const Transform& to_world);
};

// What a scene does with an instance.
enum class InstanceUse : uint8_t {
  asked,  // its sidecar is asked where a segment could meet its box
  left,   // every segment that could meet its box is left to the caller: it has no object, or one that answers nothing,
          // or its transform is flat, or not finite, or so large or small that floats cannot hold its inverse. Where
          // the box cannot be told either (something is not finite), that is every segment
  absent,  // no segment meets it: its box is empty, or has no extent in the world (scale 0, as engines hide things)
};

// What a segment could still meet.
struct UnclassifiedPair {
  uint32_t segment;  // index in the query's array
  uint32_t instance;
  float length;  // of the segment's line inside the instance's box, in 256ths of the box; 256 where it is not known
};

struct SceneQuery {
  uint32_t mask = 0xFFFFFFFF;
  // The instance that each segment begins on, or kNoInstance; empty if unknown. A bundle has one. It is left to the
  // caller without a look-up, and before all others are looked up: from inside a box a look-up seldom answers.
  std::span<const uint32_t> origins = {};
  // The triangle of that instance's object that each segment begins on, as Object::classify_self() takes it, or
  // kNoPrimitive; empty if unknown. Where the object has horizons that prove it clear, the caller is not asked about it.
  std::span<const uint32_t> primitives = {};
};
inline constexpr uint32_t kNoInstance = 0xFFFFFFFF, kNoPrimitive = 0xFFFFFFFF;

// Segments of an array or a bundle that could meet one instance: for the caller's own hierarchy over its object.
struct UnclassifiedSegments {
  uint32_t instance;
  SegmentArrays segments;   // t as in the world; at most 256, readable up to a multiple of 16
  const uint32_t* indices;  // of the same segments in the query
  uint8_t* blocked;         // 0 for each of them: to become 1 where the instance blocks it
  // false: the segments are in the object's frame. true: they are in the world's, as they were asked, because the
  // instance's transform has no inverse (it is flat, or not finite), or because floats cannot hold them in the object's
  // frame. Trace them against the instance's triangles in the world, or leave `blocked` as it is to let them pass.
  bool in_world;
};

// A reference to the caller's function from UnclassifiedSegments to nothing, which must outlive the query.
class TraceUnclassified {
 public:
  template <class Trace>
  requires(!std::is_same_v<std::remove_cvref_t<Trace>, TraceUnclassified>) TraceUnclassified(Trace&& trace)
      : context_(std::addressof(trace)), call_([](const void* context, const UnclassifiedSegments& left) {
          (*static_cast<std::remove_reference_t<Trace>*>(const_cast<void*>(context)))(left);
        }) {}
  void operator()(const UnclassifiedSegments& left) const { call_(context_, left); }

 private:
  const void* context_;
  void (*call_)(const void*, const UnclassifiedSegments&);
};

class Scene {
 public:
  struct State;  // the runtime's own
  // Instances keep their indices. Errors: usage (an unknown kernel); runtime (out of memory). No instance is an error:
  // see use(). kernel: one of kernels(); empty: the fastest.
  static Result<Scene> build(std::span<const SceneInstance> instances, const std::string& kernel = {});

  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;
  ~Scene();

  size_t size() const noexcept;

  // New transforms for all instances. Errors: usage (not as many as instances); runtime (out of memory). Then nothing
  // has changed. What use() says may change with the transforms.
  std::optional<Error> set_transforms(std::span<const Transform> to_world);

  // What becomes of an instance. instance < size().
  InstanceUse use(uint32_t instance) const noexcept;

  // blocked: by some instance. clear: no instance meets the segment. Everything else is unclassified. What instances
  // promise holds in the world: see spec/proofs.md, "Scenes".
  Visibility classify(const Segment& segment, const SceneQuery& query = {}) const noexcept;
  void classify(std::span<const Segment> segments, std::span<Visibility> answers,
                const SceneQuery& query = {}) const noexcept;

  // The same, and for unclassified segments the instances that could meet them, by segment and then the longest first.
  struct Listed {
    size_t count;  // of `list`, from its beginning
    // false: there was no room for all of them, or a segment could meet any instance for all that is known: it is not
    // finite, or it has coordinates beyond 2^40, or a direction below 2^-30 with |t| beyond 2^70
    bool complete;
  };
  Listed classify(std::span<const Segment> segments, std::span<Visibility> answers, std::span<UnclassifiedPair> list,
                  const SceneQuery& query = {}) const noexcept;

  // Whether the segment is blocked. fallback(instance) -> bool is asked for instances that could meet it, until one
  // does.
  template <class Fallback>
  requires std::is_invocable_v<Fallback, uint32_t>
  bool occluded(const Segment& segment, Fallback&& fallback, const SceneQuery& query = {}) const {
    const uint32_t self = query.origins.empty() ? kNoInstance : query.origins[0];
    if (self != kNoInstance && (mask(self) & query.mask) != 0 && !clear_of_self(segment, query) && fallback(self))
      return true;
    std::array<UnclassifiedPair, kMostListed> list;
    Visibility answer;
    const auto [count, complete] = classify(std::span(&segment, 1), std::span(&answer, 1), list, query);
    if (answer != Visibility::unclassified) return answer == Visibility::blocked;
    for (size_t i = 0; i < count; ++i)
      if (list[i].instance != self && fallback(list[i].instance)) return true;
    if (complete) return false;
    for (uint32_t i = 0; i < size(); ++i)
      if (i != self && (mask(i) & query.mask) != 0 && fallback(i)) return true;
    return false;
  }

  // Which segments are blocked, a bit for each: blocked[i / 64] >> i % 64 & 1. trace(const UnclassifiedSegments&) is
  // asked for instances that segments could meet and that no other is known to block, for many segments at once, those
  // first that most segments could meet.
  void occluded(std::span<const Segment> segments, std::span<uint64_t> blocked, TraceUnclassified trace,
                const SceneQuery& query = {}) const;
  // The bundle is in the world's frame. See <vcd/runtime/bundle.h>: promises hold for every segment to a point within
  // 2^-15 of the extents of an instance's box of the sample, in that box's frame.
  void occluded(const QuadBundle& bundle, std::span<uint64_t> blocked, TraceUnclassified trace,
                const SceneQuery& query = {}) const;
  void occluded(const SphereBundle& bundle, std::span<uint64_t> blocked, TraceUnclassified trace,
                const SceneQuery& query = {}) const;
  void occluded(const PointBundle& bundle, std::span<uint64_t> blocked, TraceUnclassified trace,
                const SceneQuery& query = {}) const;

  // Whether every instance that is not absent has an object with a hierarchy.
  bool has_hierarchies() const noexcept;
  // The same with no fallback: what no look-up decides, the objects' own hierarchies decide. They decide exactly, of
  // the segment that in_object() gives; where it gives none, of the triangles in the world. Needs has_hierarchies();
  // without them the call ends the program with a message.
  bool occluded(const Segment& segment, const SceneQuery& query = {}) const noexcept;
  void occluded(std::span<const Segment> segments, std::span<uint64_t> blocked,
                const SceneQuery& query = {}) const noexcept;
  void occluded(const QuadBundle& bundle, std::span<uint64_t> blocked, const SceneQuery& query = {}) const noexcept;
  void occluded(const SphereBundle& bundle, std::span<uint64_t> blocked, const SceneQuery& query = {}) const noexcept;
  void occluded(const PointBundle& bundle, std::span<uint64_t> blocked, const SceneQuery& query = {}) const noexcept;

  // The look-ups alone: segments that are neither blocked nor unclassified are clear.
  void classify(const QuadBundle& bundle, std::span<uint64_t> blocked, std::span<uint64_t> unclassified,
                const SceneQuery& query = {}) const noexcept;
  void classify(const SphereBundle& bundle, std::span<uint64_t> blocked, std::span<uint64_t> unclassified,
                const SceneQuery& query = {}) const noexcept;

  // A segment in the frame of an instance's object; t stays as it is. Nothing where the transform has no inverse, or
  // where floats cannot hold the segment: see UnclassifiedSegments::in_world.
  std::optional<Segment> in_object(uint32_t instance, const Segment& segment) const noexcept;

 private:
  static constexpr size_t kMostListed = 64;
  explicit Scene(std::unique_ptr<State> state);
  uint32_t mask(uint32_t instance) const noexcept;
  bool clear_of_self(const Segment& segment, const SceneQuery& query) const noexcept;  // of its first origin
  std::unique_ptr<State> state_;
};

}  // namespace vcd
