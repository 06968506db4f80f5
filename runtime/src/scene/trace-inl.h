// Segments through a scene: single ones, and arrays.
#if defined(VCD_RUNTIME_SCENE_TRACE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_SCENE_TRACE_INL_H
#undef VCD_RUNTIME_SCENE_TRACE_INL_H
#else
#define VCD_RUNTIME_SCENE_TRACE_INL_H
#endif

#include <array>
#include <optional>

#include "hierarchy/array-inl.h"
#include "hierarchy/trace-inl.h"
#include "scene/pairs-inl.h"
#include "scene/trace.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

bool OccludedInScene(const SceneData& scene, const Segment& segment, const SceneQuery& query) noexcept {
  return occluded_in_scene(scene, segment, begin_of(query, 0), query.mask, BoxesMet, Occluded);
}

// A segment is asked of one instance after another.
class SceneSource {
 public:
  SceneSource(const SceneData& scene, std::span<const Segment> segments, const SceneQuery& query)
      : scene_(scene), segments_(segments), query_(query) {}

  HWY_INLINE bool begin(uint8_t k, uint32_t index) {
    const Segment& segment = segments_[index];
    const Begin begins = begin_of(query_, index);
    from_[k] = &segment;
    if (is_trusted(segment)) return candidates_[k].emplace(scene_, segment, begins, query_.mask), true;
    candidates_[k].reset();
    return !occluded_in_scene(scene_, segment, begins, query_.mask, BoxesMet, Occluded);
  }
  HWY_INLINE Next next(uint8_t k, Segment& segment) {
    if (!candidates_[k]) return {nullptr, false};
    for (;;) {
      const uint32_t instance = candidates_[k]->next(scene_, BoxesMet);
      if (instance == kNoInstance) return {nullptr, false};
      const bool look_up = candidates_[k]->looks_up(scene_, instance);
      const Entered entered = enter(scene_, instance, *from_[k], candidates_[k]->begin(), look_up, segment);
      if (entered.object || entered.blocked) return {entered.object, entered.blocked};
    }
  }

 private:
  const SceneData& scene_;
  std::span<const Segment> segments_;
  const SceneQuery& query_;
  std::array<std::optional<Candidates>, kFlights> candidates_;  // none: the segment is not trusted, and was answered
  const Segment* from_[kFlights];
};

SampleBits OccludedArrayInScene(const SceneData& scene, std::span<const Segment> segments,
                                const SceneQuery& query) noexcept {
  const SampleBits live = WithoutPassing(scene.box, segments.data(), SampleBits::first(segments.size()));
  if (!scene.streams) return occluded_array_in_scene(scene, segments, query, live, BoxesMet, Occluded);
  SceneSource source(scene, segments, query);
  return Stream(source).blocked(live);
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
