// Segments against one box, one a lane: most of an array's may pass by the object, or by the whole scene.
#if defined(VCD_RUNTIME_HIERARCHY_BOX_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_HIERARCHY_BOX_LANES_INL_H
#undef VCD_RUNTIME_HIERARCHY_BOX_LANES_INL_H
#else
#define VCD_RUNTIME_HIERARCHY_BOX_LANES_INL_H
#endif

#include <algorithm>

#include "hierarchy/traced.h"
#include "lookup/lanes-inl.h"
#include "lookup/sample_bits.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

// The segments that pass by the box for certain, even if it is grown by 2^-16 of its reach: make_near_ray() finds the
// same of one by the same steps, and has the bound of their rounding. Of segments that begin beyond 8 reaches nothing
// is certain.
HWY_INLINE Truth passes_by(const ReachBox& box, const Lanes& lanes) {
  Floats size[3], at[3];
  for (int a = 0; a < 3; ++a) size[a] = hn::Abs(lanes.direction[a]), at[a] = hn::Abs(lanes.origin[a]);
  const Floats length = hn::Max(size[0], hn::Max(size[1], size[2]));
  const Floats farthest = hn::Max(at[0], hn::Max(at[1], at[2]));
  const Floats room = all(0x1p-16f * box.reach);
  Floats enter = hn::Mul(lanes.t_min, length), leave = hn::Mul(lanes.t_max, length);
  Truth known = hn::And(hn::Le(length, all(0x1p60f)), hn::Ge(length, all(0x1p-60f)));
  known = hn::And(known, hn::Le(farthest, all(8 * box.reach)));
  for (int a = 0; a < 3; ++a) {
    known = hn::And(known, hn::And(hn::Eq(lanes.origin[a], lanes.origin[a]), hn::Eq(size[a], size[a])));  // no NaN
    const Floats steep = hn::Div(length, hn::Max(size[a], hn::Mul(length, all(0x1p-40f)))),
                 reciprocal = hn::CopySign(steep, lanes.direction[a]);
    const Floats low = hn::Mul(hn::Sub(all(box.min[a]), lanes.origin[a]), reciprocal),
                 high = hn::Mul(hn::Sub(all(box.max[a]), lanes.origin[a]), reciprocal);
    enter = hn::Max(enter, hn::Sub(hn::Min(low, high), hn::Mul(room, steep)));
    leave = hn::Min(leave, hn::Add(hn::Max(low, high), hn::Mul(room, steep)));
  }
  return hn::And(known, hn::Gt(enter, leave));
}

// `live` without the segments that pass by the box. It tests groups all of whose segments are live: where some are not,
// look-ups were asked before, which know of the box.
HWY_NOINLINE SampleBits WithoutPassing(const ReachBox& box, const Segment* segments, const SampleBits& live) noexcept {
  constexpr uint64_t kGroup = (uint64_t{1} << kWidth) - 1;
  SampleBits passing{};
  for (size_t first = 0; first < kChunk; first += kWidth) {
    if ((live.word(first / 64) >> first % 64 & kGroup) != kGroup) continue;
    uint8_t bits[8] = {};
    hn::StoreMaskBits(F(), passes_by(box, load(segments + first)), bits);
    passing.add_word(first / 64, (bits[0] | uint64_t{bits[1]} << 8) << first % 64);
  }
  return live.without(passing);
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
