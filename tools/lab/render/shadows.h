// Which shadow rays of a bundle are blocked: by Embree alone, or by sidecars with Embree for what they leave
// unclassified.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <vcd/runtime/look_up_policy.h>
#include <vcd/runtime/scene.h>

#include "packets.h"
#include "world.h"

namespace vcd::render {

// Most segments of one bundle.
inline constexpr size_t kMaxBundle = 1024;

// Shadow rays from one point to samples of one light, neighbouring samples side by side. Segments run from t = 0 at the
// point to t = 1 at the light, in the world's frame.
struct Bundle {
  std::span<const Segment> segments;  // 1 … kMaxBundle
  std::span<const float> u, v;        // where each ends: world.lights[light].quad at corner + u · edge_u + v · edge_v
  uint32_t light;
  uint32_t pixel;      // that they are cast for
  uint32_t surface;    // that the point lies on: an instance, or kGroundSurface
  uint32_t primitive;  // of that instance's source mesh, or kNoPrimitive
};

// One a thread: casters keep scratch memory.
class ShadowCaster {
 public:
  virtual ~ShadowCaster() = default;
  // blocked[i] becomes 1 or 0 for segments[i].
  virtual void cast(const Bundle& bundle, std::span<uint8_t> blocked) = 0;
};

// One a thread; made before the threads start.
using MakeCaster = std::function<std::unique_ptr<ShadowCaster>()>;

// Where a bundle or a segment begins. In a scene of instances all but what begins on one of them is outside.
From from_of(const World& world, const Bundle& bundle);
From from_of(const World& world, uint32_t surface, const Segment& segment);

// What the runtime is asked with, in the world's frame. query_of() refers to the bundle.
QuadBundle quad_of(const World& world, const Bundle& bundle);
SceneQuery query_of(const Bundle& bundle, bool by_horizons = false);

// Its instances, for the runtime. objects[i] answers for world.objects[i].
Scene scene_of(const World& world, std::span<const Object> objects);

// How to answer shadow rays, by where they begin.
struct ShadowWays {
  std::array<EmbreeQuery, 3> traced = {EmbreeQuery{1}, EmbreeQuery{1}, EmbreeQuery{1}};  // what is not looked up
  std::array<EmbreeQuery, 3> left = traced;  // what look-ups leave unclassified
  LookUpPolicy policy{LookUpPolicy::Use::always, LookUpPolicy::Use::always, LookUpPolicy::Use::always};

  ShadowWays() = default;
  ShadowWays(EmbreeQuery all) : traced{all, all, all}, left{all, all, all} {}  // NOLINT: one way for all is a way
};

class BvhShadows : public ShadowCaster {
 public:
  BvhShadows(const World& world, const ShadowWays& ways) : world_(world), ways_(ways) {}
  void cast(const Bundle& bundle, std::span<uint8_t> blocked) override {
    occluded(world_.shadow_casters(), ways_.traced[static_cast<size_t>(from_of(world_, bundle))], bundle.segments,
             blocked.data());
  }

 private:
  const World& world_;
  ShadowWays ways_;
};

// Sidecars first, where the policy says so; Embree for what they leave unclassified: of one object as if there were no
// sidecar, in a scene of instances object by object.
class SidecarShadows : public ShadowCaster {
 public:
  // objects[i] answers for world.objects[i].
  SidecarShadows(const World& world, std::span<const Object> objects, const ShadowWays& ways);
  void cast(const Bundle& bundle, std::span<uint8_t> blocked) override;

  // The first half of cast(): what the sidecars say. answers[i] is unclassified where segments[i] has to be traced.
  void look_up(const Bundle& bundle, std::span<Visibility> answers);

 private:
  using Bits = std::array<uint64_t, kMaxBundle / 64>;

  // Into blocked_ and open_.
  void look_up(const Bundle& bundle);
  void trace_open(const Bundle& bundle, EmbreeQuery query, std::span<uint8_t> blocked);

  const World& world_;
  ShadowWays ways_;
  std::optional<Object> object_;       // of a single one
  std::optional<Scene> scene_;         // of many
  std::vector<RTCScene> hierarchies_;  // of their objects, by instance
  // Scratch: what the sidecars say of a bundle's segments, and those that have to be traced.
  Bits blocked_, open_;
  std::vector<Segment> picked_;
  std::vector<uint16_t> places_;
  std::vector<uint8_t> traced_;
};

bool have_hierarchies(std::span<const Object> objects);
bool some_has_horizons(std::span<const Object> objects);

// Sidecars with their hierarchies, and no Embree.
class HierarchyShadows : public ShadowCaster {
 public:
  // objects[i] answers for world.objects[i] and has a hierarchy. Whether it is looked up first was said when it was
  // opened. by_horizons: horizons are asked first of what begins on an object.
  HierarchyShadows(const World& world, std::span<const Object> objects, bool by_horizons = false);
  void cast(const Bundle& bundle, std::span<uint8_t> blocked) override;

 private:
  const World& world_;
  bool by_horizons_;
  std::optional<Object> object_;  // of a single one
  std::optional<Scene> scene_;    // of many
};

}  // namespace vcd::render
