// Embree behind one small class: watertight rays to classify cells with. The audit does not use it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <embree3/rtcore.h>

#include <vcd/baker/mesh.h>
#include <vcd/format/error.h>
#include <vcd/format/segment.h>

namespace vcd::baker {

enum class TraceMode {
  robust,  // no ray slips between two triangles that share an edge, and whether a ray hits depends on ray and triangles
           // only, not on the shape of the hierarchy or the number of threads: for baking and checking
  fast,    // Embree's default, as renderers use it: for benchmarks
};

// A committed scene of one mesh. Safe from any thread.
class Tracer {
 public:
  // Copies the positions; triangles must index them. device: Embree's to build on (retained), null for one of its own.
  // Errors: runtime (out of memory).
  static Result<Tracer> build(std::span<const Position> positions, std::span<const TriangleIndices> triangles,
                              TraceMode mode = TraceMode::robust, RTCDevice device = nullptr);

  // How many rays to trace together: 16 where the processor has AVX-512, else 8 (Embree then cuts packets of sixteen up
  // again, which costs a third).
  uint32_t packet_width() const { return packet_width_; }

  // Bit k of the result: ray k is occluded. Only the `count` first rays (1 … packet_width()) are looked at; tfar may be
  // overwritten. coherent: the rays lie close together.
  uint32_t occluded(RTCRay16& rays, uint32_t count, bool coherent) const;
  bool occluded(const Segment& segment) const;

  RTCScene scene() const { return scene_.get(); }

 private:
  struct ReleaseDevice {
    void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
  };
  struct ReleaseScene {
    void operator()(RTCScene s) const { rtcReleaseScene(s); }
  };
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene> scene_;
  uint32_t packet_width_ = 8;
};

}  // namespace vcd::baker
