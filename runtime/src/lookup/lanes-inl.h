// Segments through the tree, one a lane. Included once for each kind of processor.
#if defined(VCD_RUNTIME_LOOKUP_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_LOOKUP_LANES_INL_H
#undef VCD_RUNTIME_LOOKUP_LANES_INL_H
#else
#define VCD_RUNTIME_LOOKUP_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>

#include <vcd/format/line_cell.h>
#include <vcd/format/segment.h>
#include <vcd/format/tree.h>
#include <vcd/runtime/segment_arrays.h>

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
constexpr size_t kTogether = std::max<size_t>(64, kWidth);

HWY_INLINE Floats all(float x) { return hn::Set(F(), x); }
HWY_INLINE Words all(uint32_t x) { return hn::Set(U(), x); }
HWY_INLINE Words gather(const uint32_t* from, Words index) {
  return hn::BitCast(U(), hn::GatherIndex(I(), reinterpret_cast<const int32_t*>(from), hn::BitCast(I(), index)));
}

// Towards zero; anything of what no integer holds: to define that takes ConvertTo() four more steps.
HWY_INLINE Ints truncated(Floats x) {
#if HWY_TARGET <= HWY_AVX3
  return Ints{_mm512_cvttps_epi32(x.raw)};
#elif HWY_TARGET <= HWY_AVX2
  return Ints{_mm256_cvttps_epi32(x.raw)};
#else
  return hn::ConvertTo(I(), x);
#endif
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

// What locate() in <vcd/format/line_cell.h> says of lines, one a lane.
struct Lines {
  Truth valid;
  Floats entry, exit;
  Words pair, low, high;  // and its faces
  Truth swapped;          // they enter by the higher face of the pair
  Words stuv;             // s, t, u, v, one byte each
};

// The low kBits bits above bit kLow of each byte, side by side: row_major().
template <uint32_t kLow, uint32_t kBits>
HWY_INLINE Words row_major_of(Words stuv) {
  constexpr uint32_t kMask = (1u << kBits) - 1;
  const Words bytes = hn::And(hn::ShiftRight<kLow>(stuv), all(kMask * 0x01010101u));
  const Words pairs =
      hn::And(hn::Or(bytes, hn::ShiftRight<8 - kBits>(bytes)), all(((1u << 2 * kBits) - 1) * 0x00010001u));
  return hn::And(hn::Or(pairs, hn::ShiftRight<16 - 2 * kBits>(pairs)), all((1u << 4 * kBits) - 1));
}

#if HWY_IS_ASAN
#define VCD_LOCATE_INLINE HWY_NOINLINE  // forty-eight copies with checks would compile for minutes
#else
#define VCD_LOCATE_INLINE HWY_INLINE
#endif

// The same operations in the same order as locate(), for valid lines that hit. Of others pair and stuv are anything
// that exists.
VCD_LOCATE_INLINE Lines locate_lines(const GridFrame& frame, const Lanes& lanes) {
  const Floats zero = hn::Zero(F());
  Floats p[3], q[3], near[3], far[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = hn::Mul(hn::Sub(lanes.origin[i], all(frame.min[i])), all(frame.scale[i]));
    q[i] = hn::Mul(lanes.direction[i], all(frame.scale[i]));
  }
  const auto norm = [](const Floats(&x)[3])
                        HWY_ATTR { return hn::Add(hn::Add(hn::Abs(x[0]), hn::Abs(x[1])), hn::Abs(x[2])); };
  const Floats distance = norm(p), length = norm(q);
  const Truth valid = hn::And(hn::Le(distance, all(kFarthestOrigin)),
                              hn::And(hn::Ge(length, all(kShortestDirection)), hn::Le(length, all(kLongestDirection))));
  for (int i = 0; i < 3; ++i) {
    q[i] = hn::CopySign(hn::Max(hn::Abs(q[i]), all(kSmallestComponent)), q[i]);
    const Floats reciprocal = hn::Div(all(1.0f), q[i]);
    const Floats at_low = hn::Mul(hn::Sub(zero, p[i]), reciprocal),
                 at_high = hn::Mul(hn::Sub(all(kGrid), p[i]), reciprocal);
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
  const Words entry_face =
      of_axis(entry_x, entry_z, negative[0], hn::Add(negative[1], all(2u)), hn::Add(negative[2], all(4u)));
  const Words exit_face = hn::Xor(
      of_axis(exit_x, exit_z, negative[0], hn::Add(negative[1], all(2u)), hn::Add(negative[2], all(4u))), all(1u));
  Floats e[3], x[3];
  for (int i = 0; i < 3; ++i) {
    e[i] = hn::Add(hn::Mul(q[i], entry), p[i]);
    x[i] = hn::Add(hn::Mul(q[i], exit), p[i]);
  }
  const Floats e1 = hn::IfThenElse(entry_x, e[1], e[0]), e2 = hn::IfThenElse(entry_z, e[1], e[2]);
  const Floats x1 = hn::IfThenElse(exit_x, x[1], x[0]), x2 = hn::IfThenElse(exit_z, x[1], x[2]);
  const Truth swapped = hn::RebindMask(F(), hn::Gt(hn::BitCast(I(), entry_face), hn::BitCast(I(), exit_face)));
  const auto byte = [](Floats coordinate) HWY_ATTR {
    const Ints i = truncated(coordinate);
    return hn::BitCast(U(), hn::Min(hn::Max(i, hn::Zero(I())), hn::Set(I(), 255)));
  };
  const Words s = byte(hn::IfThenElse(swapped, x1, e1)), t = byte(hn::IfThenElse(swapped, x2, e2));
  const Words u = byte(hn::IfThenElse(swapped, e1, x1)), v = byte(hn::IfThenElse(swapped, e2, x2));
  const Words low = hn::Min(entry_face, exit_face), high = hn::Max(entry_face, exit_face);
  // Pairs before those whose lower face is `low`: low · (9 − low) / 2; the first of them has high = low + 1.
  const Words pair = hn::Sub(hn::Add(hn::ShiftRight<1>(hn::Mul(low, hn::Sub(all(9u), low))), high), all(1u));

  const Words stuv = hn::Or(hn::Or(hn::ShiftLeft<24>(s), hn::ShiftLeft<16>(t)), hn::Or(hn::ShiftLeft<8>(u), v));
  return {valid, entry, exit, pair, low, high, swapped, stuv};
}

// place_of() and widened() in <vcd/format/answer.h>, for lanes.
struct Places {
  Truth valid, outside, pierces;  // none of the three: ends_inside. outside and pierces count only where valid
};
HWY_INLINE Places places_of(const Lanes& lanes, const Lines& lines) {
  return {lines.valid,
          hn::Or(hn::Not(hn::Lt(lines.entry, lines.exit)),
                 hn::Or(hn::Ge(lanes.t_min, lines.exit), hn::Le(lanes.t_max, lines.entry))),
          hn::And(hn::Le(lanes.t_min, lines.entry), hn::Ge(lanes.t_max, lines.exit))};
}

// within_clearances(), for lines that meet the box. Of others it is anything.
HWY_NOINLINE Truth within_clearances_lanes(const uint8_t* clearances, const Lanes& lanes, const Lines& lines) {
  const auto clearance = [&](Words face, Words first, Words second) HWY_ATTR {
    const Words square =
        hn::Or(hn::ShiftLeft<8>(face), hn::Or(hn::ShiftLeft<4>(hn::And(first, all(15u))), hn::And(second, all(15u))));
    const Words word = gather(reinterpret_cast<const uint32_t*>(clearances), hn::ShiftRight<2>(square));
    const Words byte = hn::And(hn::Shr(word, hn::ShiftLeft<3>(hn::And(square, all(3u)))), all(255u));
    return hn::Mul(hn::ConvertTo(F(), hn::BitCast(I(), byte)), all(1 / kGrid));
  };
  const Floats at_low = clearance(lines.low, hn::ShiftRight<28>(lines.stuv), hn::ShiftRight<20>(lines.stuv));
  const Floats at_high = clearance(lines.high, hn::ShiftRight<12>(lines.stuv), hn::ShiftRight<4>(lines.stuv));
  const Floats way = hn::Sub(lines.exit, lines.entry);
  const Floats at_entry = hn::IfThenElse(lines.swapped, at_high, at_low),
               at_exit = hn::IfThenElse(lines.swapped, at_low, at_high);
  return hn::And(hn::Lt(lanes.t_min, lanes.t_max),
                 hn::And(hn::Le(hn::Sub(lanes.t_min, lines.entry), hn::Mul(at_entry, way)),
                         hn::Le(hn::Sub(lines.exit, lanes.t_max), hn::Mul(at_exit, way))));
}
HWY_INLINE Places widened_lanes(Places places, const uint8_t* clearances, const Lanes& lanes, const Lines& lines) {
  if (!clearances) return places;
  const Truth ends_inside = hn::AndNot(hn::Or(places.outside, places.pierces), places.valid);
  if (!hn::AllFalse(F(), ends_inside))
    places.pierces = hn::Or(places.pierces, hn::And(ends_inside, within_clearances_lanes(clearances, lanes, lines)));
  return places;
}

// The rows of the table: AnswerTable::row().
HWY_INLINE Words rows_of(const AnswerTable& answers, const Places& places) {
  const auto row = [&](Place place) HWY_ATTR { return all(answers.row(place)); };
  const auto where = [](Truth truth, Words yes, Words no)
                         HWY_ATTR { return hn::IfThenElse(hn::RebindMask(U(), truth), yes, no); };
  const Words inside = where(places.pierces, row(Place::pierces), row(Place::ends_inside));
  return where(places.valid, where(places.outside, row(Place::outside), inside), row(Place::doubtful));
}

// Where in the top table to look. Rows that do not depend on the cell read the spare slot.
template <uint32_t kDepth>
HWY_INLINE Words top_slots(const Lines& lines, Words rows) {
  constexpr TreeShape kShape = tree_shape(kDepth);
  Words slots = lines.pair;
  if constexpr (kShape.top_levels > 0)
    slots = hn::Or(hn::ShiftLeft<4 * kShape.top_levels>(lines.pair),
                   row_major_of<8 - kShape.top_levels, kShape.top_levels>(lines.stuv));
  const auto constant =
      hn::Or(hn::Eq(rows, all(AnswerTable::kAllClear)), hn::Eq(rows, all(AnswerTable::kAllUnclassified)));
  return hn::IfThenElse(constant, all(kShape.top_words()), slots);
}

#undef VCD_LOCATE_INLINE

// Segments with their lines.
struct LocatedLanes {
  Lanes lanes;
  Lines lines;
};

// `groups` times kWidth segments of the source from `first` on, kTogether at most. Grid and Source are types and not
// lambdas, which GCC may leave as calls that return all lanes through memory.
template <uint32_t kDepth, class Grid, class Source>
HWY_INLINE void classify_groups(const Grid& grid, const TreeView& tree, const Source& source, size_t first,
                                size_t groups, Visibility* answers) {
  constexpr TreeShape kShape = tree_shape(kDepth);
  constexpr uint32_t kBrickLow = 8 - kShape.levels;
  HWY_ALIGN uint32_t index[kTogether], stuv[kTogether], row[kTogether];
  for (size_t g = 0; g < groups; ++g) {
    const auto [lanes, lines] = grid.locate(source.group(first + g * kWidth));
    const Words rows = rows_of(tree.answers, widened_lanes(places_of(lanes, lines), tree.clearances, lanes, lines));
    hn::Store(gather(tree.top, top_slots<kDepth>(lines, rows)), U(), index + g * kWidth);
    hn::Store(lines.stuv, U(), stuv + g * kWidth);
    hn::Store(rows, U(), row + g * kWidth);
  }
  const auto through_blocks = [&]<uint32_t kLevel>() HWY_ATTR {
    if constexpr (kLevel < kShape.block_levels)
      for (size_t at = 0; at < groups * kWidth; at += kWidth) {
        const Words word = hn::Or(hn::ShiftLeft<4>(hn::Load(U(), index + at)),
                                  row_major_of<7 - kShape.top_levels - kLevel, 1>(hn::Load(U(), stuv + at)));
        hn::Store(gather(tree.blocks[kLevel], word), U(), index + at);
      }
  };
  through_blocks.template operator()<0>();
  through_blocks.template operator()<1>();
  through_blocks.template operator()<2>();
  for (size_t at = 0; at < groups * kWidth; at += kWidth) {
    const Words cell = row_major_of<kBrickLow, 2>(hn::Load(U(), stuv + at));
    const Words word = hn::Or(hn::ShiftLeft<4>(hn::Load(U(), index + at)), hn::ShiftRight<4>(cell));
    const Words bits = hn::Shr(gather(reinterpret_cast<const uint32_t*>(tree.bricks), word),
                               hn::ShiftLeft<1>(hn::And(cell, all(15u))));
    const Words answer = hn::Shr(hn::Load(U(), row + at), hn::ShiftLeft<1>(hn::And(bits, all(3u))));
    const hn::Rebind<uint8_t, I> bytes;
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(I(), hn::And(answer, all(3u)))), bytes,
               reinterpret_cast<uint8_t*>(answers + at));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
