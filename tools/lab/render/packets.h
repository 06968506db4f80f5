// Segments through Embree, in each of the ways that it offers.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <embree3/rtcore.h>

#include <vcd/runtime/embree.h>

namespace vcd::render {

std::string name_of(EmbreeQuery packets);  // "rtcOccluded16, coherent"

// All that are sound for a scene: without the coherent flag where it holds instances. There Embree 3.13.5 with AVX-512
// was seen never to return from a coherent rtcOccluded16, on an everyday bundle of shadow rays.
std::vector<EmbreeQuery> all_packets(bool instances);

bool occluded_by_bvh(RTCScene scene, const Segment& segment);  // rtcOccluded1

}  // namespace vcd::render
