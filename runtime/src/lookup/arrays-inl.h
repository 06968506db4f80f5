// Arrays of segments.
#if defined(VCD_RUNTIME_LOOKUP_ARRAYS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_LOOKUP_ARRAYS_INL_H
#undef VCD_RUNTIME_LOOKUP_ARRAYS_INL_H
#else
#define VCD_RUNTIME_LOOKUP_ARRAYS_INL_H
#endif

#include <span>

#include "lookup/grids-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

// group(i): segments i … i + kWidth - 1. one(i): segment i.
template <uint32_t kDepth, class Grid, class Group, class One>
HWY_INLINE void classify_all(const Grid& grid, const TreeView& tree, size_t count, const Group& group, const One& one,
                             Visibility* answers) {
  size_t done = 0;
  while (count - done >= kWidth) {
    const size_t groups = std::min(kTogether, count - done) / kWidth;
    classify_groups<kDepth>(
        tree, groups, [&](size_t g) HWY_ATTR { return grid.locate(group(done + g * kWidth)); }, answers + done);
    done += groups * kWidth;
  }
  if (done == count) return;
  Segment rest[kWidth] = {};
  Visibility found[kWidth];
  for (size_t i = done; i < count; ++i) rest[i - done] = one(i);
  classify_groups<kDepth>(
      tree, 1, [&](size_t) HWY_ATTR { return grid.locate(load(rest)); }, found);
  std::copy_n(found, count - done, answers + done);
}

template <uint32_t kDepth>
void ClassifySegments(const GridFrame& frame, const TreeView& tree, std::span<const Segment> segments,
                      Visibility* answers) noexcept {
  classify_all<kDepth>(
      OwnLanes{frame}, tree, segments.size(), [&](size_t i) HWY_ATTR { return load(segments.data() + i); },
      [&](size_t i) { return segments[i]; }, answers);
}

template <uint32_t kDepth, class Grid, class From>
void ClassifyArrays(const From& from, const TreeView& tree, const SegmentArrays& segments,
                    Visibility* answers) noexcept {
  classify_all<kDepth>(
      Grid{from}, tree, segments.count, [&](size_t i) HWY_ATTR { return load(segments, i); },
      [&](size_t i) { return segment_at(segments, i); }, answers);
}

template <uint32_t kDepth>
constexpr TreeKernels TreeKernelsOf() {
  return {&ClassifySegments<kDepth>, &ClassifyArrays<kDepth, OwnLanes, GridFrame>,
          &ClassifyArrays<kDepth, PlacedLanes, ToGrid>};
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
