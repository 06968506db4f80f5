// Single segments through a scene.
#if defined(VCD_RUNTIME_SCENE_TRACE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_SCENE_TRACE_INL_H
#undef VCD_RUNTIME_SCENE_TRACE_INL_H
#else
#define VCD_RUNTIME_SCENE_TRACE_INL_H
#endif

#include "hierarchy/trace-inl.h"
#include "scene/pairs-inl.h"
#include "scene/trace.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

bool OccludedInScene(const SceneData& scene, const Segment& segment, const SceneQuery& query) noexcept {
  return occluded_in_scene(scene, segment, query, BoxesMet, Occluded);
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
