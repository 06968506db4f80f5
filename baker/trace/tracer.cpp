#include <vcd/baker/tracer.h>

#include <cfenv>
#include <cstring>
#include <string>

namespace vcd::baker {
namespace {

// Sixteen lanes on, then sixteen off: count lanes are on from kLanes + 16 - count.
constexpr int32_t kLanes[32] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};

RTCIntersectContext make_context(bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

RTCRay8 first_eight(const RTCRay16& rays) {
  RTCRay8 half;
  const auto copy = [](auto& to, const auto& from) { std::memcpy(to, from, sizeof to); };
  copy(half.org_x, rays.org_x), copy(half.org_y, rays.org_y), copy(half.org_z, rays.org_z);
  copy(half.dir_x, rays.dir_x), copy(half.dir_y, rays.dir_y), copy(half.dir_z, rays.dir_z);
  copy(half.tnear, rays.tnear), copy(half.tfar, rays.tfar), copy(half.time, rays.time);
  copy(half.mask, rays.mask), copy(half.id, rays.id), copy(half.flags, rays.flags);
  return half;
}

uint32_t hit_mask(const float* tfar, uint32_t count) {
  uint32_t mask = 0;
  for (uint32_t k = 0; k < count; ++k) mask |= static_cast<uint32_t>(tfar[k] < 0) << k;
  return mask;
}

// Embree leaves the calling thread so that it flushes subnormal numbers: what is baked next could have other bytes.
class FloatingPointMode {
 public:
  FloatingPointMode() { std::fegetenv(&mode_); }
  ~FloatingPointMode() { std::fesetenv(&mode_); }
  FloatingPointMode(const FloatingPointMode&) = delete;
  FloatingPointMode& operator=(const FloatingPointMode&) = delete;

 private:
  std::fenv_t mode_;
};

}  // namespace

Result<Tracer> Tracer::build(std::span<const Position> positions, std::span<const TriangleIndices> triangles,
                             TraceMode mode, RTCDevice device) {
  const FloatingPointMode as_it_was;
  Tracer tracer;
  if (device) {
    rtcRetainDevice(device);
  } else {
    device = rtcNewDevice(nullptr);
  }
  tracer.device_.reset(device);
  if (!device) {
    const bool no_memory = rtcGetDeviceError(nullptr) == RTC_ERROR_OUT_OF_MEMORY;
    return Error{ErrorCode::runtime, no_memory ? "out of memory for Embree" : "Embree gives no device"};
  }
  tracer.packet_width_ = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) ? 16 : 8;
  tracer.scene_.reset(rtcNewScene(device));
  if (mode == TraceMode::robust) rtcSetSceneFlags(tracer.scene(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Position),
                                           positions.size());
  void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(TriangleIndices),
                                          triangles.size());
  if (vertices && indices) {
    std::memcpy(vertices, positions.data(), positions.size_bytes());
    std::memcpy(indices, triangles.data(), triangles.size_bytes());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(tracer.scene(), geometry);
  }
  rtcReleaseGeometry(geometry);
  rtcCommitScene(tracer.scene());
  if (const RTCError code = rtcGetDeviceError(device); code == RTC_ERROR_OUT_OF_MEMORY)
    return Error{ErrorCode::runtime,
                 "out of memory for Embree's hierarchy over " + std::to_string(triangles.size()) + " triangles"};
  else if (code != RTC_ERROR_NONE)
    return Error{ErrorCode::runtime, "Embree could not build its hierarchy over " + std::to_string(triangles.size()) +
                                         " triangles (error " + std::to_string(code) + ")"};
  return tracer;
}

uint32_t Tracer::occluded(RTCRay16& rays, uint32_t count, bool coherent) const {
  RTCIntersectContext context = make_context(coherent);
  alignas(64) int32_t lanes[16];
  std::memcpy(lanes, kLanes + 16 - count, sizeof lanes);
  if (packet_width_ == 16) {
    rtcOccluded16(lanes, scene(), &context, &rays);
    return hit_mask(rays.tfar, count);
  }
  RTCRay8 half = first_eight(rays);
  rtcOccluded8(lanes, scene(), &context, &half);
  return hit_mask(half.tfar, count);
}

bool Tracer::occluded(const Segment& segment) const {
  if (!(segment.t_min < segment.t_max)) return false;
  RTCIntersectContext context = make_context(false);
  RTCRay ray{};
  ray.org_x = segment.origin[0], ray.org_y = segment.origin[1], ray.org_z = segment.origin[2];
  ray.dir_x = segment.direction[0], ray.dir_y = segment.direction[1], ray.dir_z = segment.direction[2];
  ray.tnear = segment.t_min;
  ray.tfar = segment.t_max;
  ray.mask = 0xFFFFFFFF;
  if (segment.t_min < 0) {  // Embree wants tnear ≥ 0: begin at the segment's own beginning
    ray.org_x += segment.t_min * ray.dir_x, ray.org_y += segment.t_min * ray.dir_y,
        ray.org_z += segment.t_min * ray.dir_z;
    ray.tnear = 0;
    ray.tfar = segment.t_max - segment.t_min;
  }
  rtcOccluded1(scene(), &context, &ray);
  return ray.tfar < 0;
}

}  // namespace vcd::baker
