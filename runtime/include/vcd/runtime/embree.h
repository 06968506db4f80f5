// For renderers on Embree (3 or 4): rtcOccluded1, 8 and 16 with the sidecar asked first, for one object and for scenes
// of instances. Header-only; include it after Embree's own header: #include <embree3/rtcore.h> or #include
// <embree4/rtcore.h>.
//
// An RTCScene that stands for an object must hold exactly the triangles of the object's mesh, in the object's frame.
// Masks, filters and time of a ray apply only where it is traced: ask Embree directly for rays that must not see all of
// the mesh, or use the masks of <vcd/runtime/scene.h>.
#pragma once

#ifndef RTC_VERSION_MAJOR
#error "include Embree's rtcore.h before vcd/runtime/embree.h"
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>

namespace vcd {

// How to ask Embree.
struct EmbreeQuery {
  unsigned width = 16;    // 1, 8 or 16 rays at once
  bool coherent = false;  // RTC_INTERSECT_CONTEXT_FLAG_COHERENT, RTC_RAY_QUERY_FLAG_COHERENT
};

namespace embree_detail {

inline constexpr float kBlocked = -std::numeric_limits<float>::infinity();  // as Embree says it, in tfar

#if RTC_VERSION_MAJOR >= 4
inline RTCOccludedArguments arguments(bool coherent) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  if (coherent) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  return arguments;
}
inline void occluded(const int*, RTCScene scene, RTCRay& ray, bool coherent) {
  RTCOccludedArguments a = arguments(coherent);
  rtcOccluded1(scene, &ray, &a);
}
inline void occluded(const int* valid, RTCScene scene, RTCRay8& rays, bool coherent) {
  RTCOccludedArguments a = arguments(coherent);
  rtcOccluded8(valid, scene, &rays, &a);
}
inline void occluded(const int* valid, RTCScene scene, RTCRay16& rays, bool coherent) {
  RTCOccludedArguments a = arguments(coherent);
  rtcOccluded16(valid, scene, &rays, &a);
}
#else
inline RTCIntersectContext context(bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}
inline void occluded(const int*, RTCScene scene, RTCRay& ray, bool coherent) {
  RTCIntersectContext c = context(coherent);
  rtcOccluded1(scene, &c, &ray);
}
inline void occluded(const int* valid, RTCScene scene, RTCRay8& rays, bool coherent) {
  RTCIntersectContext c = context(coherent);
  rtcOccluded8(valid, scene, &c, &rays);
}
inline void occluded(const int* valid, RTCScene scene, RTCRay16& rays, bool coherent) {
  RTCIntersectContext c = context(coherent);
  rtcOccluded16(valid, scene, &c, &rays);
}
#endif

}  // namespace embree_detail

inline Segment segment_of(const RTCRay& ray) {
  return {{ray.org_x, ray.org_y, ray.org_z}, ray.tnear, {ray.dir_x, ray.dir_y, ray.dir_z}, ray.tfar};
}
inline RTCRay to_ray(const Segment& s) {
  RTCRay ray{};
  ray.org_x = s.origin[0], ray.org_y = s.origin[1], ray.org_z = s.origin[2];
  ray.dir_x = s.direction[0], ray.dir_y = s.direction[1], ray.dir_z = s.direction[2];
  ray.tnear = s.t_min, ray.tfar = s.t_max, ray.mask = 0xFFFFFFFF;
  return ray;
}
// Ray k of an RTCRay8 or RTCRay16.
template <class Rays>
Segment segment_of(const Rays& rays, size_t k) {
  return {{rays.org_x[k], rays.org_y[k], rays.org_z[k]},
          rays.tnear[k],
          {rays.dir_x[k], rays.dir_y[k], rays.dir_z[k]},
          rays.tfar[k]};
}

namespace embree_detail {

template <class Get>
void trace_one_by_one(RTCScene scene, bool coherent, size_t size, const Get& segment, uint8_t* answers) {
  for (size_t i = 0; i < size; ++i) {
    RTCRay ray = to_ray(segment(i));
    occluded(nullptr, scene, ray, coherent);
    answers[i] = ray.tfar == kBlocked;
  }
}

inline constexpr size_t kFew = 3;  // rays that a packet does not pay for

// segment(i): number i.
template <class Rays, size_t kWidth, class Get>
void trace(RTCScene scene, bool coherent, size_t size, const Get& segment, uint8_t* answers) {
  for (size_t first = 0; first < size; first += kWidth) {
    const size_t count = std::min(kWidth, size - first);
    if (count <= kFew)
      return trace_one_by_one(
          scene, coherent, size - first, [&](size_t i) { return segment(first + i); }, answers + first);
    alignas(64) int valid[kWidth];
    Rays rays;
    for (size_t k = 0; k < kWidth; ++k) {
      const Segment s = segment(first + std::min(k, count - 1));
      valid[k] = k < count ? -1 : 0;
      rays.org_x[k] = s.origin[0], rays.org_y[k] = s.origin[1], rays.org_z[k] = s.origin[2];
      rays.dir_x[k] = s.direction[0], rays.dir_y[k] = s.direction[1], rays.dir_z[k] = s.direction[2];
      rays.tnear[k] = s.t_min, rays.tfar[k] = s.t_max, rays.time[k] = 0;
      rays.mask[k] = 0xFFFFFFFF, rays.id[k] = 0, rays.flags[k] = 0;
    }
    occluded(valid, scene, rays, coherent);
    for (size_t k = 0; k < count; ++k) answers[first + k] = rays.tfar[k] == kBlocked;
  }
}

template <class Get>
void trace(RTCScene scene, EmbreeQuery query, size_t size, const Get& segment, uint8_t* answers) {
  if (query.width == 16) return trace<RTCRay16, 16>(scene, query.coherent, size, segment, answers);
  if (query.width == 8) return trace<RTCRay8, 8>(scene, query.coherent, size, segment, answers);
  trace_one_by_one(scene, query.coherent, size, segment, answers);
}

}  // namespace embree_detail

// Segments through Embree alone, query.width at once, neighbours together. answers[i] becomes 1 where segment i is
// blocked, else 0. t_min must not be negative.
inline void occluded(RTCScene scene, EmbreeQuery query, std::span<const Segment> segments, uint8_t* answers) {
  embree_detail::trace(
      scene, query, segments.size(), [&](size_t i) { return segments[i]; }, answers);
}
inline void occluded(RTCScene scene, EmbreeQuery query, const SegmentArrays& segments, uint8_t* answers) {
  embree_detail::trace(
      scene, query, segments.count, [&](size_t i) { return segment_at(segments, i); }, answers);
}

// Like rtcOccluded1 (tnear must not be negative): a blocked ray's tfar becomes -infinity, another one's is left alone.
// Returns true if the ray had to be traced.
#if RTC_VERSION_MAJOR >= 4
inline bool occluded1(Object object, RTCScene scene, RTCRay* ray, RTCOccludedArguments* arguments = nullptr) {
  const Visibility answer = object.classify(segment_of(*ray));
  if (answer == Visibility::unclassified) rtcOccluded1(scene, ray, arguments);
#else
inline bool occluded1(Object object, RTCScene scene, RTCIntersectContext* context, RTCRay* ray) {
  const Visibility answer = object.classify(segment_of(*ray));
  if (answer == Visibility::unclassified) rtcOccluded1(scene, context, ray);
#endif
  if (answer == Visibility::blocked) ray->tfar = embree_detail::kBlocked;
  return answer == Visibility::unclassified;
}

// Like rtcOccluded8 and rtcOccluded16, for RTCRay8 and RTCRay16: rays with valid[k] = -1 (tnear must not be negative).
// Returns how many had to be traced.
template <class Rays>
size_t occluded_packet(Object object, const int* valid, RTCScene scene, Rays* rays, bool coherent = false) {
  constexpr size_t kWidth = sizeof(rays->tfar) / sizeof(float);
  std::array<Visibility, kWidth> answers;
  object.classify(SegmentArrays{{rays->org_x, rays->org_y, rays->org_z},
                                rays->tnear,
                                {rays->dir_x, rays->dir_y, rays->dir_z},
                                rays->tfar,
                                kWidth},
                  answers);
  alignas(64) int left[kWidth];
  size_t count = 0;
  for (size_t k = 0; k < kWidth; ++k) {
    left[k] = answers[k] == Visibility::unclassified ? valid[k] : 0;
    count += left[k] != 0;
    if (valid[k] && answers[k] == Visibility::blocked) rays->tfar[k] = embree_detail::kBlocked;
  }
  if (count > 0) embree_detail::occluded(left, scene, *rays, coherent);
  return count;
}

// Traces what a Scene leaves unclassified: objects[i] holds the triangles of instance i's object, in the object's
// frame. No instances of Embree's are needed.
struct EmbreeInstances {
  std::span<const RTCScene> objects;
  EmbreeQuery query = {};
  // in_world[i] holds the triangles of instance i in the world's frame, where its transform is flat or otherwise
  // without an inverse. Null or none: nothing is blocked there, as by an instance of Embree's that has such a
  // transform.
  std::span<const RTCScene> in_world = {};

  // Null: nothing to trace.
  RTCScene hierarchy(uint32_t instance, bool of_world) const {
    if (!of_world) return objects[instance];
    return instance < in_world.size() ? in_world[instance] : nullptr;
  }
  void operator()(const UnclassifiedSegments& left) const {
    if (const RTCScene scene = hierarchy(left.instance, left.in_world))
      vcd::occluded(scene, query, left.segments, left.blocked);
  }
};

// Like rtcOccluded1 over all instances: a blocked ray's tfar becomes -infinity, another one's is left alone.
inline void occluded1(const Scene& scene, const EmbreeInstances& instances, RTCRay* ray, const SceneQuery& query = {}) {
  const Segment segment = segment_of(*ray);
  const bool blocked = scene.occluded(
      segment,
      [&](uint32_t instance) {
        const auto in_object = scene.in_object(instance, segment);
        const RTCScene hierarchy = instances.hierarchy(instance, !in_object);
        if (!hierarchy) return false;
        RTCRay inside = to_ray(in_object.value_or(segment));
        embree_detail::occluded(nullptr, hierarchy, inside, false);
        return inside.tfar == embree_detail::kBlocked;
      },
      query);
  if (blocked) ray->tfar = embree_detail::kBlocked;
}

// Like rtcOccluded8 and rtcOccluded16 over all instances.
template <class Rays>
void occluded_packet(const Scene& scene, const EmbreeInstances& instances, const int* valid, Rays* rays,
                     const SceneQuery& query = {}) {
  constexpr size_t kWidth = sizeof(rays->tfar) / sizeof(float);
  std::array<Segment, kWidth> segments;
  std::array<uint32_t, kWidth> origins;
  std::array<size_t, kWidth> lanes;
  size_t count = 0;
  for (size_t k = 0; k < kWidth; ++k) {
    if (!valid[k]) continue;
    origins[count] = k < query.origins.size() ? query.origins[k] : kNoInstance;
    segments[count] = segment_of(*rays, k);
    lanes[count++] = k;
  }
  uint64_t blocked = 0;
  const SceneQuery of_valid{query.mask,
                            query.origins.empty() ? query.origins : std::span<const uint32_t>(origins).first(count)};
  scene.occluded(std::span(segments).first(count), std::span(&blocked, 1), instances, of_valid);
  for (size_t i = 0; i < count; ++i)
    if (blocked >> i & 1) rays->tfar[lanes[i]] = embree_detail::kBlocked;
}

}  // namespace vcd
