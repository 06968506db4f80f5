// What answers the shadow rays of a path tracer, one by one or many at once: Embree, or sidecars.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <vcd/runtime/scene.h>

#include "path_rays.h"
#include "shadows.h"
#include "sidecars.h"

namespace vcd::render {

inline constexpr size_t kWavefront = 4096;  // paths that advance together

// Shadow rays in the order in which they are asked, and the arrays in which they can be asked together.
struct AskedRays {
  std::vector<Segment> segments;
  std::vector<uint32_t> origins;     // an instance or kNoInstance
  std::vector<uint32_t> primitives;  // of it, or kNoPrimitive
  std::vector<From> from;
  struct Array {
    size_t first, count;
  };
  std::vector<Array> arrays;  // neighbours of one wavefront and bounce that begin alike

  AskedRays() = default;
  explicit AskedRays(std::span<const PathRay> rays);
};

// From path by path to wavefronts: the first rays of kWavefront paths, by where they begin, then their second ones, and
// so on.
void sort_as_wavefronts(std::vector<PathRay>& rays);

// By sidecars with hierarchies, without Embree: one object, or a scene of instances. Safe from any thread.
class SidecarPaths {
 public:
  // objects[i] answers for world.objects[i]. by_horizons: horizons are asked first of what begins on the object.
  SidecarPaths(const World& world, std::span<const Object> objects, bool by_horizons = false);

  bool occluded(const AskedRays& rays, size_t i) const {
    if (object_ && by_horizons_ && rays.from[i] == From::self)
      return object_->occluded_self(rays.segments[i], rays.primitives[i]);
    if (object_) return object_->occluded(rays.segments[i], rays.from[i]);
    return scene_->occluded(rays.segments[i], query(rays, {i, 1}));
  }
  // A bit a segment of the array, as Object::occluded() gives them.
  void occluded(const AskedRays& rays, AskedRays::Array array, std::span<uint64_t> blocked) const;
  // Look-ups, and rtcOccluded1 for what they leave: of one object `casters`, in a scene the object's own.
  bool occluded_by(RTCScene casters, const AskedRays& rays, size_t i) const;

 private:
  SceneQuery query(const AskedRays& rays, AskedRays::Array array) const {
    SceneQuery query{0xFFFFFFFF, std::span(rays.origins).subspan(array.first, array.count)};
    if (by_horizons_) query.primitives = std::span(rays.primitives).subspan(array.first, array.count);
    return query;
  }

  bool by_horizons_;
  std::optional<Object> object_;
  std::optional<Scene> scene_;
  std::vector<RTCScene> hierarchies_;  // Embree's, by instance
};

// One a thread: what a picture's shadow rays are cast with.
class PathCaster {
 public:
  virtual ~PathCaster() = default;
  // blocked[i] becomes 1 or 0 for segment i.
  virtual void cast(const AskedRays& rays, std::span<uint8_t> blocked) = 0;
};

class BvhPaths : public PathCaster {
 public:
  // way: one ray a call, or how many of an array at once.
  BvhPaths(const World& world, EmbreeQuery way) : casters_(world.shadow_casters()), way_(way) {}
  void cast(const AskedRays& rays, std::span<uint8_t> blocked) override;

 private:
  RTCScene casters_;
  EmbreeQuery way_;
};

class HierarchyPaths : public PathCaster {
 public:
  // paths outlives this.
  HierarchyPaths(const SidecarPaths& paths, bool wavefronts) : paths_(paths), wavefronts_(wavefronts) {}
  void cast(const AskedRays& rays, std::span<uint8_t> blocked) override;

 private:
  const SidecarPaths& paths_;
  bool wavefronts_;
};

}  // namespace vcd::render
