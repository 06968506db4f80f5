#include "packets.h"

#include <algorithm>

namespace vcd {
namespace {

void occluded(const int* valid, RTCScene scene, RTCIntersectContext* context, RTCRay8* rays) {
  rtcOccluded8(valid, scene, context, rays);
}
void occluded(const int* valid, RTCScene scene, RTCIntersectContext* context, RTCRay16* rays) {
  rtcOccluded16(valid, scene, context, rays);
}

template <class Rays, size_t kWidth>
void trace_packets(RTCScene scene, RTCIntersectContext& context, std::span<const Segment> segments, uint8_t* answers) {
  for (size_t first = 0; first < segments.size(); first += kWidth) {
    const size_t count = std::min(kWidth, segments.size() - first);
    alignas(64) int valid[kWidth];
    Rays rays;
    for (size_t k = 0; k < kWidth; ++k) {
      const Segment& s = segments[first + std::min(k, count - 1)];
      valid[k] = k < count ? -1 : 0;
      rays.org_x[k] = s.origin[0], rays.org_y[k] = s.origin[1], rays.org_z[k] = s.origin[2];
      rays.dir_x[k] = s.direction[0], rays.dir_y[k] = s.direction[1], rays.dir_z[k] = s.direction[2];
      rays.tnear[k] = s.t_min, rays.tfar[k] = s.t_max, rays.time[k] = 0;
      rays.mask[k] = 0xFFFFFFFF, rays.id[k] = 0, rays.flags[k] = 0;
    }
    occluded(valid, scene, &context, &rays);
    for (size_t k = 0; k < count; ++k) answers[first + k] = rays.tfar[k] < 0;
  }
}

}  // namespace

std::string Packets::name() const {
  return "rtcOccluded" + std::to_string(width) + (coherent ? ", coherent" : "");
}

std::vector<Packets> all_packets(bool instances) {
  if (instances) return {{1, false}, {8, false}, {16, false}};
  return {{1, false}, {1, true}, {8, false}, {8, true}, {16, false}, {16, true}};
}

RTCRay to_ray(const Segment& s) {
  RTCRay ray{};
  ray.org_x = s.origin[0], ray.org_y = s.origin[1], ray.org_z = s.origin[2];
  ray.dir_x = s.direction[0], ray.dir_y = s.direction[1], ray.dir_z = s.direction[2];
  ray.tnear = s.t_min, ray.tfar = s.t_max, ray.mask = 0xFFFFFFFF;
  return ray;
}

void trace(RTCScene scene, Packets packets, std::span<const Segment> segments, std::span<uint8_t> answers) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (packets.coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  switch (packets.width) {
    case 8: return trace_packets<RTCRay8, 8>(scene, context, segments, answers.data());
    case 16: return trace_packets<RTCRay16, 16>(scene, context, segments, answers.data());
    default:
      for (size_t i = 0; i < segments.size(); ++i) {
        RTCRay ray = to_ray(segments[i]);
        rtcOccluded1(scene, &context, &ray);
        answers[i] = ray.tfar < 0;
      }
  }
}

}  // namespace vcd
