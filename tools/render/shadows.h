// Which shadow rays of a bundle are blocked: by Embree alone, or by sidecars with Embree for what they leave open.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <vcd/runtime/sidecar.h>

#include "instance_tree.h"
#include "packets.h"
#include "world.h"

namespace vcd {

// Most segments of one bundle.
inline constexpr size_t kMaxBundle = 1024;

// Shadow rays from one point to samples of one light, neighbouring samples side by side. Segments run from t = 0 at the
// point to t = 1 at the light, in the world's frame.
struct Bundle {
  std::span<const Segment> segments;  // 1 … kMaxBundle
  std::span<const float> u, v;        // where each ends: world.lights[light].quad at corner + u · edge_u + v · edge_v
  uint32_t light;
  uint32_t pixel;    // that they are cast for
  uint32_t surface;  // that the point lies on: an instance, or kGroundSurface
};

// One a thread: casters keep scratch memory.
class ShadowCaster {
 public:
  virtual ~ShadowCaster() = default;
  // blocked[i] becomes 1 or 0 for segments[i].
  virtual void cast(const Bundle& bundle, std::span<uint8_t> blocked) = 0;
};

class BvhShadows : public ShadowCaster {
 public:
  BvhShadows(const World& world, Packets packets) : scene_(world.shadow_casters()), packets_(packets) {}
  void cast(const Bundle& bundle, std::span<uint8_t> blocked) override {
    trace(scene_, packets_, bundle.segments, blocked);
  }

 private:
  RTCScene scene_;
  Packets packets_;
};

// Sidecars first; what they leave open goes to Embree, as if there were none. In a scene of instances the bundle as a whole is
// led through a hierarchy over their boxes, and each instance that it could meet is asked; one blocked answer ends a segment.
class SidecarShadows : public ShadowCaster {
 public:
  // objects[i] answers for world.objects[i].
  SidecarShadows(const World& world, std::span<const Object> objects, Packets packets);
  void cast(const Bundle& bundle, std::span<uint8_t> blocked) override;

  // The first half of cast(): what the sidecars say. answers[i] is unclassified where segments[i] has to be traced.
  void look_up(const Bundle& bundle, std::span<Visibility> answers);

 private:
  using Bits = std::array<uint64_t, kMaxBundle / 64>;

  // Into blocked_ and open_.
  void look_up(const Bundle& bundle);

  const World& world_;
  std::vector<Object> objects_;
  Packets packets_;
  InstanceTree instances_;
  // Scratch: what the sidecars say of a bundle's segments, and those that have to be traced.
  Bits blocked_, open_, instance_blocked_, instance_open_;
  std::vector<Segment> picked_;
  std::vector<uint16_t> places_;
  std::vector<uint8_t> traced_;
};

}  // namespace vcd
