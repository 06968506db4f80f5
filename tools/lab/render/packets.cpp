#include "packets.h"

namespace vcd::render {

std::string name_of(EmbreeQuery packets) {
  return "rtcOccluded" + std::to_string(packets.width) + (packets.coherent ? ", coherent" : "");
}

std::vector<EmbreeQuery> all_packets(bool instances) {
  if (instances) return {{1, false}, {8, false}, {16, false}};
  return {{1, false}, {1, true}, {8, false}, {8, true}, {16, false}, {16, true}};
}

bool occluded_by_bvh(RTCScene scene, const Segment& segment) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = to_ray(segment);
  rtcOccluded1(scene, &context, &ray);
  return ray.tfar < 0;
}

}  // namespace vcd::render
