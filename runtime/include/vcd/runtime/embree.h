// For renderers on Embree (3 or 4): rtcOccluded1 with the sidecar asked first. Header-only; include it after Embree's
// own header: #include <embree3/rtcore.h> or #include <embree4/rtcore.h>.
//
// The scene must hold exactly the triangles of the object's mesh, in the object's frame. With instances, ask the
// object per instance with the ray transformed into its frame, and your top-level scene for what is left.
#pragma once

#ifndef RTC_VERSION_MAJOR
#error "include Embree's rtcore.h before vcd/runtime/embree.h"
#endif

#include <limits>

#include <vcd/runtime/sidecar.h>

namespace vcd {

inline Segment segment_of(const RTCRay& ray) {
  return {{ray.org_x, ray.org_y, ray.org_z}, ray.tnear, {ray.dir_x, ray.dir_y, ray.dir_z}, ray.tfar};
}

// Like rtcOccluded1 (tnear must not be negative): a blocked ray's tfar becomes -infinity, another one's is left alone. Returns true if the ray had
// to be traced. Masks, filters and time of the ray apply only where it is traced: ask the scene directly for rays
// that must not see all of the mesh.
#if RTC_VERSION_MAJOR >= 4
inline bool occluded1(Object object, RTCScene scene, RTCRay* ray, RTCOccludedArguments* arguments = nullptr) {
  const Visibility answer = object.classify(segment_of(*ray));
  if (answer == Visibility::unclassified) rtcOccluded1(scene, ray, arguments);
#else
inline bool occluded1(Object object, RTCScene scene, RTCIntersectContext* context, RTCRay* ray) {
  const Visibility answer = object.classify(segment_of(*ray));
  if (answer == Visibility::unclassified) rtcOccluded1(scene, context, ray);
#endif
  if (answer == Visibility::blocked) ray->tfar = -std::numeric_limits<float>::infinity();
  return answer == Visibility::unclassified;
}

}  // namespace vcd
