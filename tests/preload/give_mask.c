// Debian's Open3D asks shadow rays with mask 0, and Debian's Embree heeds masks, so that nothing is ever hit. This
// gives the rays a mask: LD_PRELOAD=libgive_mask.so, before all others.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <embree3/rtcore.h>

void rtcOccluded1M(RTCScene scene, struct RTCIntersectContext* context, struct RTCRay* rays, unsigned count,
                   size_t stride) {
  static void (*next)(RTCScene, struct RTCIntersectContext*, struct RTCRay*, unsigned, size_t);
  if (!next) *(void**)&next = dlsym(RTLD_NEXT, "rtcOccluded1M");
  for (unsigned i = 0; i < count; ++i) ((struct RTCRay*)((char*)rays + i * stride))->mask = 0xFFFFFFFFu;
  next(scene, context, rays, count, stride);
}
