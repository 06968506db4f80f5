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

// Where segments come from.
struct FromStructures {
  std::span<const Segment> segments;

  size_t count() const { return segments.size(); }
  HWY_INLINE Lanes group(size_t first) const { return load(segments.data() + first); }  // kWidth of them
  Segment one(size_t i) const { return segments[i]; }
};
struct FromArrays {
  const SegmentArrays& segments;

  size_t count() const { return segments.count; }
  HWY_INLINE Lanes group(size_t first) const { return load(segments, first); }
  Segment one(size_t i) const { return segment_at(segments, i); }
};

template <uint32_t kDepth, class Grid, class Source>
HWY_INLINE void classify_all(const Grid& grid, const TreeView& tree, const Source& source, Visibility* answers) {
  const size_t count = source.count();
  size_t done = 0;
  while (count - done >= kWidth) {
    const size_t groups = std::min(kTogether, count - done) / kWidth;
    classify_groups<kDepth>(grid, tree, source, done, groups, answers + done);
    done += groups * kWidth;
  }
  if (done == count) return;
  Segment rest[kWidth] = {};
  Visibility found[kWidth];
  for (size_t i = done; i < count; ++i) rest[i - done] = source.one(i);
  classify_groups<kDepth>(grid, tree, FromStructures{rest}, 0, 1, found);
  std::copy_n(found, count - done, answers + done);
}

template <uint32_t kDepth>
void ClassifySegments(const GridFrame& frame, const TreeView& tree, std::span<const Segment> segments,
                      Visibility* answers) noexcept {
  classify_all<kDepth>(OwnLanes{frame}, tree, FromStructures{segments}, answers);
}

template <uint32_t kDepth, class Grid, class From>
void ClassifyArrays(const From& from, const TreeView& tree, const SegmentArrays& segments,
                    Visibility* answers) noexcept {
  classify_all<kDepth>(Grid{from}, tree, FromArrays{segments}, answers);
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
