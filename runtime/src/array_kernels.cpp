// Look-ups a lane: Billen and Dutré 2016, section 5, by the arithmetic of <vcd/format/line_cell.h>.
#include "array_kernels.h"

// Three kinds of x86-64 are enough: SSE4, AVX2 and AVX-512.
#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS HWY_SSSE3
#endif
// This file is compiled once for each kind of processor.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "array_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "object_data.h"

#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128  // single calls are faster than these
HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
using Floats = hn::VFromD<F>;
using Ints = hn::VFromD<I>;
using Words = hn::VFromD<U>;
using Truth = hn::MFromD<F>;
constexpr size_t kWidth = hn::MaxLanes(F());

// Segments that go through the tree level by level together, so that their cache misses overlap.
constexpr size_t kChunk = std::max<size_t>(64, kWidth);

HWY_INLINE Floats all(float x) { return hn::Set(F(), x); }
HWY_INLINE Words all(uint32_t x) { return hn::Set(U(), x); }
HWY_INLINE Words gather(const uint32_t* from, Words index) {
  return hn::BitCast(U(), hn::GatherIndex(I(), reinterpret_cast<const int32_t*>(from), hn::BitCast(I(), index)));
}

struct Lanes {
  Floats origin[3], direction[3], t_min, t_max;
};

// Segments are {origin, t_min}, {direction, t_max}: each a group of four floats.
HWY_INLINE Lanes load(const Segment* segments) {
  const float* from = segments->origin;
  Floats a[4], b[4];
  hn::LoadInterleaved4(F(), from, a[0], a[1], a[2], a[3]);
  hn::LoadInterleaved4(F(), from + 4 * kWidth, b[0], b[1], b[2], b[3]);
  Lanes lanes;
  for (int i = 0; i < 3; ++i) {
    lanes.origin[i] = hn::ConcatEven(F(), b[i], a[i]);
    lanes.direction[i] = hn::ConcatOdd(F(), b[i], a[i]);
  }
  lanes.t_min = hn::ConcatEven(F(), b[3], a[3]);
  lanes.t_max = hn::ConcatOdd(F(), b[3], a[3]);
  return lanes;
}
HWY_INLINE Lanes load(const SegmentArrays& from, size_t at) {
  Lanes lanes;
  for (int i = 0; i < 3; ++i) {
    lanes.origin[i] = hn::LoadU(F(), from.origin[i] + at);
    lanes.direction[i] = hn::LoadU(F(), from.direction[i] + at);
  }
  lanes.t_min = hn::LoadU(F(), from.t_min + at);
  lanes.t_max = hn::LoadU(F(), from.t_max + at);
  return lanes;
}

// What classify() in <vcd/format/tree.h> knows of a segment before it looks at the tree.
struct Located {
  Words slot;     // in the top table
  Words stuv;     // s, t, u, v, one byte each
  Words answers;  // by the cell's bits
};

// The low kBits bits above bit kLow of each byte, side by side: row_major().
template <uint32_t kLow, uint32_t kBits>
HWY_INLINE Words row_major_of(Words stuv) {
  constexpr uint32_t kMask = (1u << kBits) - 1;
  const Words bytes = hn::And(hn::ShiftRight<kLow>(stuv), all(kMask * 0x01010101u));
  const Words pairs = hn::And(hn::Or(bytes, hn::ShiftRight<8 - kBits>(bytes)), all(((1u << 2 * kBits) - 1) * 0x00010001u));
  return hn::And(hn::Or(pairs, hn::ShiftRight<16 - 2 * kBits>(pairs)), all((1u << 4 * kBits) - 1));
}

// locate() of <vcd/format/line_cell.h>, a segment a lane: for valid lines the same operations in the same order. What
// becomes of the others does not matter, but for their slot, which is always one of the table's.
template <uint32_t kDepth>
HWY_INLINE Located locate_lanes(const ObjectData& data, const Lanes& lanes) {
  constexpr TreeShape kShape = tree_shape(kDepth);
  const Floats zero = hn::Zero(F());
  Floats p[3], q[3], near[3], far[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = hn::Mul(hn::Sub(lanes.origin[i], all(data.frame.min[i])), all(data.frame.scale[i]));
    q[i] = hn::Mul(lanes.direction[i], all(data.frame.scale[i]));
  }
  const auto norm = [](const Floats(&x)[3]) HWY_ATTR { return hn::Add(hn::Add(hn::Abs(x[0]), hn::Abs(x[1])), hn::Abs(x[2])); };
  const Floats distance = norm(p), length = norm(q);
  const Truth valid = hn::And(hn::Le(distance, all(kFarthestOrigin)),
                              hn::And(hn::Ge(length, all(kShortestDirection)), hn::Le(length, all(kLongestDirection))));
  for (int i = 0; i < 3; ++i) {
    q[i] = hn::CopySign(hn::Max(hn::Abs(q[i]), all(kSmallestComponent)), q[i]);
    const Floats reciprocal = hn::Div(all(1.0f), q[i]);
    const Floats at_low = hn::Mul(hn::Sub(zero, p[i]), reciprocal), at_high = hn::Mul(hn::Sub(all(kGrid), p[i]), reciprocal);
    near[i] = hn::Min(at_low, at_high);
    far[i] = hn::Max(at_low, at_high);
  }
  const Floats entry = hn::Max(near[0], hn::Max(near[1], near[2])), exit = hn::Min(far[0], hn::Min(far[1], far[2]));

  // The lowest axis of entry and exit; the faces, 2 · axis + side; the two coordinates in the plane of each.
  const Truth entry_x = hn::Eq(near[0], entry), entry_z = hn::AndNot(hn::Eq(near[1], entry), hn::Not(entry_x));
  const Truth exit_x = hn::Eq(far[0], exit), exit_z = hn::AndNot(hn::Eq(far[1], exit), hn::Not(exit_x));
  Words negative[3];
  for (int i = 0; i < 3; ++i) negative[i] = hn::ShiftRight<31>(hn::BitCast(U(), q[i]));
  const auto of_axis = [](Truth x, Truth z, auto a, auto b, auto c) HWY_ATTR {
    const hn::DFromV<decltype(a)> d;
    return hn::IfThenElse(hn::RebindMask(d, x), a, hn::IfThenElse(hn::RebindMask(d, z), c, b));
  };
  const Words entry_face = of_axis(entry_x, entry_z, negative[0], hn::Add(negative[1], all(2u)), hn::Add(negative[2], all(4u)));
  const Words exit_face = hn::Xor(of_axis(exit_x, exit_z, negative[0], hn::Add(negative[1], all(2u)), hn::Add(negative[2], all(4u))), all(1u));
  Floats e[3], x[3];
  for (int i = 0; i < 3; ++i) {
    e[i] = hn::Add(hn::Mul(q[i], entry), p[i]);
    x[i] = hn::Add(hn::Mul(q[i], exit), p[i]);
  }
  const Floats e1 = hn::IfThenElse(entry_x, e[1], e[0]), e2 = hn::IfThenElse(entry_z, e[1], e[2]);
  const Floats x1 = hn::IfThenElse(exit_x, x[1], x[0]), x2 = hn::IfThenElse(exit_z, x[1], x[2]);
  const Truth swapped = hn::RebindMask(F(), hn::Gt(hn::BitCast(I(), entry_face), hn::BitCast(I(), exit_face)));
  const auto byte = [](Floats coordinate) HWY_ATTR {
    const Ints i = hn::ConvertTo(I(), coordinate);
    return hn::BitCast(U(), hn::Min(hn::Max(i, hn::Zero(I())), hn::Set(I(), 255)));
  };
  const Words s = byte(hn::IfThenElse(swapped, x1, e1)), t = byte(hn::IfThenElse(swapped, x2, e2));
  const Words u = byte(hn::IfThenElse(swapped, e1, x1)), v = byte(hn::IfThenElse(swapped, e2, x2));
  const Words low = hn::Min(entry_face, exit_face), high = hn::Max(entry_face, exit_face);
  // Pairs before those whose lower face is `low`: low · (9 − low) / 2; the first of them has high = low + 1.
  const Words pair = hn::Sub(hn::Add(hn::ShiftRight<1>(hn::Mul(low, hn::Sub(all(9u), low))), high), all(1u));

  Located located;
  located.stuv = hn::Or(hn::Or(hn::ShiftLeft<24>(s), hn::ShiftLeft<16>(t)), hn::Or(hn::ShiftLeft<8>(u), v));
  const Truth outside = hn::Or(hn::Not(hn::Lt(entry, exit)), hn::Or(hn::Ge(lanes.t_min, exit), hn::Le(lanes.t_max, entry)));
  const Truth pierces = hn::And(hn::Le(lanes.t_min, entry), hn::Ge(lanes.t_max, exit));
  // Lines that miss the box, and those that nothing in this tree can answer, read the spare slot.
  Truth answerable = valid;
  if (!data.tree.has_clear) answerable = data.tree.has_blocked ? hn::And(valid, hn::Or(outside, pierces)) : hn::And(valid, outside);
  located.slot = all(kShape.top_words());
  Words in_table = pair;
  if constexpr (kShape.top_levels > 0)
    in_table = hn::Or(hn::ShiftLeft<4 * kShape.top_levels>(pair), row_major_of<8 - kShape.top_levels, kShape.top_levels>(located.stuv));
  located.slot = hn::IfThenElse(hn::RebindMask(U(), hn::AndNot(outside, answerable)), in_table, located.slot);
  constexpr uint32_t kNone = 0b10'10'10'10u, kClearOnly = 0b10'10'10'00u;
  const Words answers = hn::IfThenElse(hn::RebindMask(U(), pierces), all(kClearOnly ^ data.tree.blocked_answers), all(kClearOnly));
  located.answers = hn::IfThenElse(hn::RebindMask(U(), answerable), answers, all(kNone));
  return located;
}

// groups · kWidth segments, at most kChunk, that load_group(i) gives in groups.
template <uint32_t kDepth, class Load>
HWY_INLINE void classify_chunk(const ObjectData& data, size_t groups, const Load& load_group, Visibility* answers) {
  constexpr TreeShape kShape = tree_shape(kDepth);
  constexpr uint32_t kBrickLow = 8 - kShape.levels;
  HWY_ALIGN uint32_t index[kChunk], stuv[kChunk], table[kChunk];
  for (size_t g = 0; g < groups; ++g) {
    const Located located = locate_lanes<kDepth>(data, load_group(g));
    hn::Store(gather(data.tree.top, located.slot), U(), index + g * kWidth);
    hn::Store(located.stuv, U(), stuv + g * kWidth);
    hn::Store(located.answers, U(), table + g * kWidth);
  }
  if constexpr (kShape.has_blocks256) {
    constexpr uint32_t kLow = 8 - kShape.top_levels - 2;
    for (size_t at = 0; at < groups * kWidth; at += kWidth) {
      const Words word = hn::Or(hn::ShiftLeft<8>(hn::Load(U(), index + at)), row_major_of<kLow, 2>(hn::Load(U(), stuv + at)));
      hn::Store(gather(data.tree.blocks256, word), U(), index + at);
    }
  }
  if constexpr (kShape.has_blocks16) {
    for (size_t at = 0; at < groups * kWidth; at += kWidth) {
      const Words word = hn::Or(hn::ShiftLeft<4>(hn::Load(U(), index + at)), row_major_of<kBrickLow + 2, 1>(hn::Load(U(), stuv + at)));
      hn::Store(gather(data.tree.blocks16, word), U(), index + at);
    }
  }
  for (size_t at = 0; at < groups * kWidth; at += kWidth) {
    const Words cell = row_major_of<kBrickLow, 2>(hn::Load(U(), stuv + at));
    const Words word = hn::Or(hn::ShiftLeft<4>(hn::Load(U(), index + at)), hn::ShiftRight<4>(cell));
    const Words bits = hn::Shr(gather(reinterpret_cast<const uint32_t*>(data.tree.bricks), word), hn::ShiftLeft<1>(hn::And(cell, all(15u))));
    const Words answer = hn::Shr(hn::Load(U(), table + at), hn::ShiftLeft<1>(hn::And(bits, all(3u))));
    const hn::Rebind<uint8_t, I> bytes;
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(I(), hn::And(answer, all(3u)))), bytes, reinterpret_cast<uint8_t*>(answers + at));
  }
}

template <uint32_t kDepth>
void ClassifySegmentsOf(const ObjectData& data, std::span<const Segment> segments, Visibility* answers) {
  size_t done = 0;
  while (segments.size() - done >= kWidth) {
    const size_t groups = std::min(kChunk, segments.size() - done) / kWidth;
    const Segment* from = segments.data() + done;
    classify_chunk<kDepth>(data, groups, [&](size_t g) HWY_ATTR { return load(from + g * kWidth); }, answers + done);
    done += groups * kWidth;
  }
  if (done == segments.size()) return;
  Segment rest[kWidth] = {};
  Visibility found[kWidth];
  std::copy(segments.begin() + static_cast<std::ptrdiff_t>(done), segments.end(), rest);
  classify_chunk<kDepth>(data, 1, [&](size_t) HWY_ATTR { return load(rest); }, found);
  std::copy_n(found, segments.size() - done, answers + done);
}

template <uint32_t kDepth>
void ClassifyArraysOf(const ObjectData& data, const SegmentArrays& segments, Visibility* answers) {
  size_t done = 0;
  while (segments.count - done >= kWidth) {
    const size_t groups = std::min(kChunk, segments.count - done) / kWidth;
    classify_chunk<kDepth>(data, groups, [&](size_t g) HWY_ATTR { return load(segments, done + g * kWidth); }, answers + done);
    done += groups * kWidth;
  }
  if (done == segments.count) return;
  Segment rest[kWidth] = {};
  Visibility found[kWidth];
  for (size_t i = done; i < segments.count; ++i) rest[i - done] = segment_at(segments, i);
  classify_chunk<kDepth>(data, 1, [&](size_t) HWY_ATTR { return load(rest); }, found);
  std::copy_n(found, segments.count - done, answers + done);
}

template <uint32_t... kDepths>
ArrayKernels kernels(std::integer_sequence<uint32_t, kDepths...>) {
  return {hwy::TargetName(HWY_TARGET), {&ClassifySegmentsOf<kDepths + 1>...}, {&ClassifyArraysOf<kDepths + 1>...}};
}
ArrayKernels Kernels() { return kernels(std::make_integer_sequence<uint32_t, kMaxDepth>()); }

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif

#if HWY_ONCE
namespace vcd {
namespace {

// One segment after the other.
template <uint32_t kDepth>
void segments_of(const ObjectData& data, std::span<const Segment> segments, Visibility* answers) {
  for (size_t i = 0; i < segments.size(); ++i) answers[i] = classify(data.frame, data.tree, tree_shape(kDepth), segments[i]);
}
template <uint32_t kDepth>
void arrays_of(const ObjectData& data, const SegmentArrays& segments, Visibility* answers) {
  for (size_t i = 0; i < segments.count; ++i)
    answers[i] = classify(data.frame, data.tree, tree_shape(kDepth), segment_at(segments, i));
}
template <uint32_t... kDepths>
ArrayKernels scalar_kernels(std::integer_sequence<uint32_t, kDepths...>) {
  return {"scalar", {&segments_of<kDepths + 1>...}, {&arrays_of<kDepths + 1>...}};
}

}  // namespace

std::vector<ArrayKernels> usable_kernels() {
  std::vector<ArrayKernels> usable;
  [[maybe_unused]] const int64_t supported = hwy::SupportedTargets();
#if HWY_TARGETS & HWY_AVX3
  if (supported & HWY_AVX3) usable.push_back(N_AVX3::Kernels());
#endif
#if HWY_TARGETS & HWY_AVX2
  if (supported & HWY_AVX2) usable.push_back(N_AVX2::Kernels());
#endif
#if HWY_TARGETS & HWY_SSE4
  if (supported & HWY_SSE4) usable.push_back(N_SSE4::Kernels());
#endif
#if HWY_TARGETS & HWY_NEON
  if (supported & HWY_NEON) usable.push_back(N_NEON::Kernels());
#endif
  usable.push_back(scalar_kernels(std::make_integer_sequence<uint32_t, kMaxDepth>()));
  return usable;
}

bool fits_gathers(const TreeView& tree) {
  constexpr uint64_t kMostWords = uint64_t{1} << 31;
  return tree.block256_count < kMostWords / kBlock256Words && tree.block16_count < kMostWords / kBlock16Words &&
         tree.brick_count < kMostWords / (kBrickBytes / 4);
}

}  // namespace vcd
#endif
