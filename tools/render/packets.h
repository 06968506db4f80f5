// Segments through Embree, in each of the ways that it offers.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <embree3/rtcore.h>

#include <vcd/format/segment.h>

namespace vcd {

struct Packets {
  uint32_t width = 1;     // 1, 8 or 16
  bool coherent = false;  // Embree's flag

  std::string name() const;  // "rtcOccluded16, coherent"
};

// All that are sound for a scene: without the coherent flag where it holds instances. There Embree 3.13.5 with AVX-512 was
// seen never to return from a coherent rtcOccluded16, on an everyday bundle of shadow rays.
std::vector<Packets> all_packets(bool instances);

// occluded[i] becomes 1 where segments[i] meets the scene, else 0. t_min must not be negative. Neighbours in the array go
// into a packet together.
void trace(RTCScene scene, Packets packets, std::span<const Segment> segments, std::span<uint8_t> occluded);

RTCRay to_ray(const Segment& segment);

}  // namespace vcd
