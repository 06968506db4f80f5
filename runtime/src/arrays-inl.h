// Arrays of segments.
#if defined(VCD_RUNTIME_ARRAYS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_ARRAYS_INL_H
#undef VCD_RUNTIME_ARRAYS_INL_H
#else
#define VCD_RUNTIME_ARRAYS_INL_H
#endif

#include "lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

HWY_INLINE Located located(const ObjectData& data, const Lanes& lanes) {
  return {lanes, locate_lines(data.frame, lanes)};
}

template <uint32_t kDepth>
void ClassifySegmentsOf(const ObjectData& data, std::span<const Segment> segments, Visibility* answers) {
  size_t done = 0;
  while (segments.size() - done >= kWidth) {
    const size_t groups = std::min(kChunk, segments.size() - done) / kWidth;
    const Segment* from = segments.data() + done;
    classify_chunk<kDepth>(
        data.tree, groups, [&](size_t g) HWY_ATTR { return located(data, load(from + g * kWidth)); }, answers + done);
    done += groups * kWidth;
  }
  if (done == segments.size()) return;
  Segment rest[kWidth] = {};
  Visibility found[kWidth];
  std::copy(segments.begin() + static_cast<std::ptrdiff_t>(done), segments.end(), rest);
  classify_chunk<kDepth>(
      data.tree, 1, [&](size_t) HWY_ATTR { return located(data, load(rest)); }, found);
  std::copy_n(found, segments.size() - done, answers + done);
}

template <uint32_t kDepth>
void ClassifyArraysOf(const ObjectData& data, const SegmentArrays& segments, Visibility* answers) {
  size_t done = 0;
  while (segments.count - done >= kWidth) {
    const size_t groups = std::min(kChunk, segments.count - done) / kWidth;
    classify_chunk<kDepth>(
        data.tree, groups, [&](size_t g) HWY_ATTR { return located(data, load(segments, done + g * kWidth)); },
        answers + done);
    done += groups * kWidth;
  }
  if (done == segments.count) return;
  Segment rest[kWidth] = {};
  Visibility found[kWidth];
  for (size_t i = done; i < segments.count; ++i) rest[i - done] = segment_at(segments, i);
  classify_chunk<kDepth>(
      data.tree, 1, [&](size_t) HWY_ATTR { return located(data, load(rest)); }, found);
  std::copy_n(found, segments.count - done, answers + done);
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
