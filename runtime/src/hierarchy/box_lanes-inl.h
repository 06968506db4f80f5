// Segments against boxes, one a lane: most of an array's may pass by the object, or by the whole scene.
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

// A box a lane, and that of all lanes.
struct BoxLanes {
  Floats min[3], max[3], reach;
};
HWY_INLINE BoxLanes all(const ReachBox& box) {
  BoxLanes lanes;
  for (size_t a = 0; a < 3; ++a) lanes.min[a] = all(box.min[a]), lanes.max[a] = all(box.max[a]);
  lanes.reach = all(box.reach);
  return lanes;
}

// How segments go through boxes that are grown by 2^-16 of their reach. make_near_ray() finds the same of one by the
// same steps, and has the bound of their rounding.
struct Passage {
  Truth known;  // neither far from the box nor beyond what can be trusted; of others the rest is anything
  Floats size[3], length, farthest;  // of the directions' components, the greatest; of the origins'
  Floats steep[3], reciprocal[3];
  Floats first, last;   // the segment, by its way along the longest axis
  Floats enter, leave;  // that of it which is in the box; enter > leave: none
};
HWY_INLINE Passage passage(const BoxLanes& box, const Lanes& lanes) {
  Passage p;
  Floats at[3];
  for (size_t a = 0; a < 3; ++a) p.size[a] = hn::Abs(lanes.direction[a]), at[a] = hn::Abs(lanes.origin[a]);
  p.length = hn::Max(p.size[0], hn::Max(p.size[1], p.size[2]));
  p.farthest = hn::Max(at[0], hn::Max(at[1], at[2]));
  p.known = hn::And(hn::Le(p.length, all(0x1p60f)), hn::Ge(p.length, all(0x1p-60f)));
  p.known = hn::And(p.known, hn::Le(p.farthest, hn::Mul(all(8.0f), box.reach)));
  const Floats outside = hn::Mul(all(4.0f), hn::Add(box.reach, p.farthest)), room = hn::Mul(all(0x1p-16f), box.reach);
  p.enter = p.first = hn::Max(hn::Mul(lanes.t_min, p.length), hn::Neg(outside));
  p.leave = p.last = hn::Min(hn::Mul(lanes.t_max, p.length), outside);
  for (size_t a = 0; a < 3; ++a) {
    p.known = hn::And(p.known, hn::And(hn::Eq(at[a], at[a]), hn::Eq(p.size[a], p.size[a])));  // no NaN
    p.steep[a] = hn::Div(p.length, hn::Max(p.size[a], hn::Mul(p.length, all(0x1p-40f))));
    p.reciprocal[a] = hn::CopySign(p.steep[a], lanes.direction[a]);
    const Floats low = hn::Mul(hn::Sub(box.min[a], lanes.origin[a]), p.reciprocal[a]),
                 high = hn::Mul(hn::Sub(box.max[a], lanes.origin[a]), p.reciprocal[a]);
    p.enter = hn::Max(p.enter, hn::NegMulAdd(room, p.steep[a], hn::Min(low, high)));
    p.leave = hn::Min(p.leave, hn::MulAdd(room, p.steep[a], hn::Max(low, high)));
  }
  return p;
}

// `live` without the segments that pass by the box for certain. It tests groups all of whose segments are live: where
// some are not, look-ups were asked before, which know of the box.
HWY_NOINLINE SampleBits WithoutPassing(const ReachBox& box, const Segment* segments, const SampleBits& live) noexcept {
  constexpr uint64_t kGroup = (uint64_t{1} << kWidth) - 1;
  SampleBits passing{};
  for (size_t first = 0; first < kChunk; first += kWidth) {
    if ((live.word(first / 64) >> first % 64 & kGroup) != kGroup) continue;
    uint8_t bits[8] = {};
    const Passage way = passage(all(box), load(segments + first));
    hn::StoreMaskBits(F(), hn::And(way.known, hn::Gt(way.enter, way.leave)), bits);
    passing.add_word(first / 64, (bits[0] | uint64_t{bits[1]} << 8) << first % 64);
  }
  return live.without(passing);
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
