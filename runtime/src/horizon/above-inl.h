// The same operations in the same order as clear_of_horizon(): of one segment, and a segment in each lane.
#if defined(VCD_RUNTIME_HORIZON_ABOVE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_HORIZON_ABOVE_INL_H
#undef VCD_RUNTIME_HORIZON_ABOVE_INL_H
#else
#define VCD_RUNTIME_HORIZON_ABOVE_INL_H
#endif

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <hwy/cache_control.h>

#include "horizon/above.h"
#include "lookup/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

// In the place of one that is not there: nothing is above it, whatever its corners are.
inline constexpr HorizonEntry kNoHorizon{0, {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}};

struct FrameLanes {
  Floats corner[3], x[3], y[3], n[3], size, u[3], v[3], top;
  Truth usable;
};

HWY_INLINE Floats along(const Floats (&axis)[3], const Floats (&r)[3]) {
  return hn::Add(hn::Add(hn::Mul(axis[0], r[0]), hn::Mul(axis[1], r[1])), hn::Mul(axis[2], r[2]));
}
HWY_INLINE Floats greatest(const Floats (&r)[3]) {
  return hn::Max(hn::Max(hn::Abs(r[0]), hn::Abs(r[1])), hn::Abs(r[2]));
}
HWY_INLINE Floats cross_part(Floats a, Floats b, Floats c, Floats d) { return hn::Sub(hn::Mul(a, b), hn::Mul(c, d)); }

// make_horizon_frame()
HWY_INLINE FrameLanes frame_lanes(const Floats (&p)[3], const Floats (&q)[3], const Floats (&r)[3]) {
  FrameLanes f;
  Floats a[3], b[3];
  for (size_t i = 0; i < 3; ++i) f.corner[i] = p[i], a[i] = hn::Sub(q[i], p[i]), b[i] = hn::Sub(r[i], p[i]);
  const Floats cross[3] = {cross_part(a[1], b[2], a[2], b[1]), cross_part(a[2], b[0], a[0], b[2]),
                           cross_part(a[0], b[1], a[1], b[0])};
  const Floats area2 = along(cross, cross);
  f.usable = hn::And(hn::Ge(area2, all(horizon::kLeastArea2)), hn::Le(area2, all(horizon::kMostArea2)));
  const Floats length = hn::Sqrt(area2), one = all(1.0f);
  for (size_t i = 0; i < 3; ++i) f.n[i] = hn::Div(cross[i], length);
  const Floats sign = hn::CopySign(one, f.n[2]), c = hn::Div(all(-1.0f), hn::Add(sign, f.n[2])),
               d = hn::Mul(hn::Mul(f.n[0], f.n[1]), c);
  f.x[0] = hn::Add(one, hn::Mul(hn::Mul(hn::Mul(sign, f.n[0]), f.n[0]), c));
  f.x[1] = hn::Mul(sign, d), f.x[2] = hn::Mul(hn::Neg(sign), f.n[0]);
  f.y[0] = d, f.y[1] = hn::Add(sign, hn::Mul(hn::Mul(f.n[1], f.n[1]), c)), f.y[2] = hn::Neg(f.n[1]);
  f.size = hn::Max(greatest(a), greatest(b));
  f.u[0] = f.v[0] = hn::Zero(F());
  f.u[1] = along(f.x, a), f.v[1] = along(f.y, a);
  f.u[2] = along(f.x, b), f.v[2] = along(f.y, b);
  f.top = hn::Max(hn::Max(along(f.n, a), along(f.n, b)), hn::Zero(F()));
  return f;
}

// begins_above()
HWY_INLINE Truth begin_above(const FrameLanes& f, const Lanes& s) {
  Floats r[3], moved[3];
  const Floats near = hn::Mul(all(horizon::kNear), f.size);
  Truth good = f.usable;
  for (size_t i = 0; i < 3; ++i) {
    r[i] = hn::Sub(s.origin[i], f.corner[i]), moved[i] = hn::Mul(s.t_min, s.direction[i]);
    good = hn::And(good, hn::And(hn::Le(hn::Abs(r[i]), near), hn::Le(hn::Abs(moved[i]), near)));
    r[i] = hn::Add(r[i], moved[i]);
  }
  const Floats u = along(f.x, r), v = along(f.y, r), w = along(f.n, r);
  good = hn::And(good, hn::Ge(hn::Sub(w, f.top), hn::Mul(all(horizon::kLowest), f.size)));
  const Floats inside = hn::Mul(hn::Mul(all(horizon::kInside), f.size), f.size);
  for (size_t i = 0; i < 3; ++i) {
    const size_t j = i == 2 ? 0 : i + 1;
    const Floats edge = hn::Sub(hn::Mul(hn::Sub(f.u[j], f.u[i]), hn::Sub(v, f.v[i])),
                                hn::Mul(hn::Sub(f.v[j], f.v[i]), hn::Sub(u, f.u[i])));
    good = hn::And(good, hn::Ge(edge, inside));
  }
  return good;
}

// Directions in a frame, with their sectors.
struct Azimuths {
  Truth good, upright;
  Floats flat, up;
  Words sector;
};

// The first part of is_above(), and horizon_sector().
HWY_INLINE Azimuths azimuths(const FrameLanes& f, const Floats (&direction)[3]) {
  const Floats size = greatest(direction), zero = hn::Zero(F());
  const Floats u = along(f.x, direction), v = along(f.y, direction), w = along(f.n, direction);
  Azimuths at;
  at.flat = hn::Add(hn::Mul(u, u), hn::Mul(v, v)), at.up = hn::Mul(w, w);
  at.good =
      hn::And(hn::And(hn::Ge(size, all(horizon::kShortest)), hn::Le(size, all(horizon::kLongest))), hn::Gt(w, zero));
  at.upright = hn::Lt(at.flat, hn::Mul(all(horizon::kUpright), at.up));
  const Floats a = hn::Abs(u), b = hn::Abs(v);
  const auto words = [](Truth truth) HWY_ATTR { return hn::RebindMask(U(), truth); };
  Words sector = hn::IfThenElseZero(words(hn::Gt(hn::Min(a, b), hn::Mul(all(horizon::kTan), hn::Max(a, b)))), all(1u));
  sector = hn::IfThenElse(words(hn::Gt(b, a)), hn::Sub(all(3u), sector), sector);
  sector = hn::IfThenElse(words(hn::Lt(u, zero)), hn::Sub(all(7u), sector), sector);
  at.sector = hn::IfThenElse(words(hn::Lt(v, zero)), hn::Sub(all(15u), sector), sector);
  return at;
}

// Where nothing stands in the way: `slopes` by sector, `never` where some sector has none.
HWY_INLINE Truth is_above(const Azimuths& at, Floats slope, Truth never) {
  const Truth steep = hn::Ge(at.up, hn::Mul(hn::Mul(slope, slope), at.flat));
  return hn::And(at.good, hn::Or(hn::And(at.upright, hn::Not(never)), hn::AndNot(at.upright, steep)));
}

// The corners of corners_at(), of small and large leaves alike: those of V vertices hold x of all of them, then y, then
// z, then the first corners of 16 triangles, then the second, then the third.
struct Corners {
  hn::Vec<hn::FixedTag<float, 4>> p, q, r;  // and a fourth lane that says nothing
};
HWY_INLINE Corners corners_of(const HierarchyView& hierarchy, uint32_t place) {
  const hn::FixedTag<float, 4> d;
  const uint32_t vertices = place & kPlaceLarge ? kLargeVertices : kNodeWidth;
  const std::byte* const leaf = hierarchy.units + size_t{place & kPlaceUnitMask} * kUnitBytes;
  for (size_t unit = 0; unit < sizeof(SmallLeaf) / kUnitBytes; ++unit) hwy::Prefetch(leaf + unit * kUnitBytes);
  const auto* const x = reinterpret_cast<const float*>(leaf);
  const auto* const corner = reinterpret_cast<const uint8_t*>(leaf) + 12 * vertices + triangle_of(place);
  const auto vertex = [&](uint8_t v) HWY_ATTR {
    const float* const at = x + (v & (vertices - 1));
    return hn::InsertLane(hn::InsertLane(hn::Set(d, at[0]), 1, at[vertices]), 2, at[2 * vertices]);
  };
  const uint32_t turned = place >> 31;
  return {vertex(corner[0]), vertex(corner[kNodeWidth * (1 + turned)]), vertex(corner[kNodeWidth * (2 - turned)])};
}
static_assert(offsetof(SmallLeaf, corner) == 12 * kNodeWidth && offsetof(LargeLeaf, corner) == 12 * kLargeVertices);

// clear_of_horizon(), the sums of several vectors at a time; without branches that scattered segments would mispredict.
HWY_INLINE bool is_clear(const Horizons& horizons, const Segment& segment, uint32_t primitive) {
  if (!horizons.view || primitive >= horizons.view.header().entries) return false;
  const HorizonEntry& entry = horizons.view.entries()[primitive];
  const hn::FixedTag<float, 4> d;
  const auto set = [](float x) HWY_ATTR { return hn::Set(hn::FixedTag<float, 4>(), x); };
  const auto bits = [](auto mask) HWY_ATTR {
    uint8_t bytes[8] = {};
    hn::StoreMaskBits(hn::FixedTag<float, 4>(), mask, bytes);
    return bytes[0] & 7u;  // of three components
  };
  HWY_ALIGN static constexpr uint32_t kYzx[4] = {1, 2, 0, 3};
  const auto yzx = [&](auto v) HWY_ATTR { return hn::TableLookupLanes(v, hn::SetTableIndices(d, kYzx)); };
  const auto most_of = [](auto v) HWY_ATTR {
    return std::max(std::max(hn::GetLane(v), hn::ExtractLane(v, 1)), hn::ExtractLane(v, 2));
  };

  // make_horizon_frame()
  const auto [p, q, r] = corners_of(horizons.hierarchy, entry.place);
  const auto a = hn::Sub(q, p), b = hn::Sub(r, p);
  const auto cross = yzx(hn::Sub(hn::Mul(a, yzx(b)), hn::Mul(yzx(a), b))), squares = hn::Mul(cross, cross);
  const float area2 = hn::GetLane(squares) + hn::ExtractLane(squares, 1) + hn::ExtractLane(squares, 2);
  bool good = (area2 >= horizon::kLeastArea2) & (area2 <= horizon::kMostArea2);
  const auto normal = hn::Div(cross, hn::Sqrt(set(area2)));
  const float n[3] = {hn::GetLane(normal), hn::ExtractLane(normal, 1), hn::ExtractLane(normal, 2)};
  const float sign = std::copysign(1.0f, n[2]), c = -1.0f / (sign + n[2]), nnc = n[0] * n[1] * c;
  const float x[3] = {1.0f + sign * n[0] * n[0] * c, sign * nnc, -sign * n[0]},
              y[3] = {nnc, sign + n[1] * n[1] * c, -n[1]};
  const float size = most_of(hn::Max(hn::Abs(a), hn::Abs(b)));

  // begins_above(), and the sums of is_above(): in the lanes the second corner, the third, the begin, the direction.
  const auto direction = hn::LoadU(d, segment.direction), from = hn::Sub(hn::LoadU(d, segment.origin), p),
             moved = hn::Mul(set(segment.t_min), direction), near = set(horizon::kNear * size);
  good &= bits(hn::And(hn::Le(hn::Abs(from), near), hn::Le(hn::Abs(moved), near))) == 7;
  const auto begin = hn::Add(from, moved);
  const auto ab_low = hn::InterleaveLower(d, a, b), ab_high = hn::InterleaveUpper(d, a, b),
             bd_low = hn::InterleaveLower(d, begin, direction), bd_high = hn::InterleaveUpper(d, begin, direction);
  const auto e0 = hn::ConcatLowerLower(d, bd_low, ab_low), e1 = hn::ConcatUpperUpper(d, bd_low, ab_low),
             e2 = hn::ConcatLowerLower(d, bd_high, ab_high);
  const auto sums = [&](const float(&axis)[3]) HWY_ATTR {
    return hn::Add(hn::Add(hn::Mul(set(axis[0]), e0), hn::Mul(set(axis[1]), e1)), hn::Mul(set(axis[2]), e2));
  };
  const auto us = sums(x), vs = sums(y), ws = sums(n);
  const float top = std::max(std::max(hn::GetLane(ws), hn::ExtractLane(ws, 1)), 0.0f);
  good &= hn::ExtractLane(ws, 2) - top >= horizon::kLowest * size;
  const auto two = hn::FirstN(d, 2);
  const auto u_next = hn::IfThenElseZero(two, us), v_next = hn::IfThenElseZero(two, vs),
             u_this = hn::ShiftLeftLanes<1>(d, u_next), v_this = hn::ShiftLeftLanes<1>(d, v_next);
  const auto edge = hn::Sub(hn::Mul(hn::Sub(u_next, u_this), hn::Sub(hn::Broadcast<2>(vs), v_this)),
                            hn::Mul(hn::Sub(v_next, v_this), hn::Sub(hn::Broadcast<2>(us), u_this)));
  good &= bits(hn::Ge(edge, set(horizon::kInside * size * size))) == 7;

  // is_above(). What horizon_sector() takes from 3, 7 or 15 has no other bits.
  const float length = most_of(hn::Abs(direction));
  const float u = hn::ExtractLane(us, 3), v = hn::ExtractLane(vs, 3), w = hn::ExtractLane(ws, 3);
  const float flat = u * u + v * v, up = w * w, wide = std::fabs(u), high = std::fabs(v);
  const auto some = [](bool condition, uint32_t number) { return (0u - uint32_t{condition}) & number; };
  const uint32_t sector = some(std::min(wide, high) > horizon::kTan * std::max(wide, high), 1) ^ some(high > wide, 3) ^
                          some(u < 0, 7) ^ some(v < 0, 15);
  const uint64_t codes = codes_of(entry);
  const float k = horizons.view.header().slope[table_of(entry.place)][horizon_code(codes, sector)];
  const bool upright = flat < horizon::kUpright * up, steep = up >= k * k * flat;
  return good & (length >= horizon::kShortest) & (length <= horizon::kLongest) & (w > 0) &
         ((upright & !has_never(codes)) | (!upright & steep));
}
bool IsClear(const Horizons& horizons, const Segment& segment, uint32_t primitive) noexcept {
  return is_clear(horizons, segment, primitive);
}

HWY_INLINE uint64_t bits_of(Truth truth) {
  HWY_ALIGN uint8_t bytes[8] = {};
  hn::StoreMaskBits(F(), truth, bytes);
  return (bytes[0] | uint64_t{bytes[1]} << 8) & ((uint64_t{1} << kWidth) - 1);
}

SampleBits AboveArray(const Horizons& horizons, const Segment* segments, const uint32_t* primitives,
                      size_t count) noexcept {
  const HorizonHeader& header = horizons.view.header();
  SampleBits clear{};
  for (size_t first = 0; first < count; first += kWidth) {
    const size_t some = std::min(kWidth, count - first);
    HWY_ALIGN float corners[3][3][kWidth];
    HWY_ALIGN float never[kWidth];
    HWY_ALIGN float slope[kWidth];
    uint64_t codes[kWidth];
    uint32_t table[kWidth];
    Segment rest[kWidth];
    for (size_t lane = 0; lane < kWidth; ++lane) {
      const size_t i = std::min(first + lane, count - 1);  // behind the last it is repeated
      rest[lane] = segments[i];
      const bool known = primitives[i] < header.entries;
      const HorizonEntry& entry = known ? horizons.view.entries()[primitives[i]] : kNoHorizon;
      codes[lane] = codes_of(entry), table[lane] = table_of(entry.place);
      never[lane] = known && !has_never(codes[lane]) ? 0.0f : 1.0f;
      float p[3], q[3], r[3];
      corners_at(horizons.hierarchy, entry.place, p, q, r);
      for (size_t a = 0; a < 3; ++a) corners[0][a][lane] = p[a], corners[1][a][lane] = q[a], corners[2][a][lane] = r[a];
    }
    Floats p[3], q[3], r[3];
    for (size_t a = 0; a < 3; ++a)
      p[a] = hn::Load(F(), corners[0][a]), q[a] = hn::Load(F(), corners[1][a]), r[a] = hn::Load(F(), corners[2][a]);
    const FrameLanes frame = frame_lanes(p, q, r);
    const Lanes lanes = load(rest);
    const Truth begin = begin_above(frame, lanes);
    const Azimuths at = azimuths(frame, lanes.direction);
    HWY_ALIGN uint32_t sector[kWidth];
    hn::Store(at.sector, U(), sector);
    for (size_t lane = 0; lane < kWidth; ++lane)
      slope[lane] = header.slope[table[lane]][horizon_code(codes[lane], sector[lane])];
    const Truth above = is_above(at, hn::Load(F(), slope), hn::Gt(hn::Load(F(), never), hn::Zero(F())));
    const uint64_t bits = bits_of(hn::And(begin, above)) & ((uint64_t{1} << some) - 1);
    clear.add_word(first / 64, bits << (first % 64));
  }
  return clear;
}

SampleBits AboveFan(const Horizons& horizons, const Fan& fan, uint32_t primitive) noexcept {
  const HorizonHeader& header = horizons.view.header();
  SampleBits clear{};
  if (primitive >= header.entries) return clear;
  const HorizonEntry& entry = horizons.view.entries()[primitive];
  HorizonFrame frame;
  const Segment begin{{fan.origin[0], fan.origin[1], fan.origin[2]}, 0.0f, {0, 0, 0}, 1.0f};
  if (!frame_at(horizons.hierarchy, entry.place, frame) || !begins_above(frame, begin)) return clear;
  FrameLanes f;
  for (size_t a = 0; a < 3; ++a) f.x[a] = all(frame.x[a]), f.y[a] = all(frame.y[a]), f.n[a] = all(frame.n[a]);
  const uint64_t codes = codes_of(entry);
  HWY_ALIGN float slopes[kHorizonSectors];
  for (uint32_t s = 0; s < kHorizonSectors; ++s)
    slopes[s] = header.slope[table_of(entry.place)][horizon_code(codes, s)];
  const Truth never = hn::Gt(all(has_never(codes) ? 1.0f : 0.0f), hn::Zero(F()));
  for (size_t i = 0; i < fan.count; i += kWidth) {
    Floats direction[3];
    for (size_t a = 0; a < 3; ++a) direction[a] = hn::LoadU(F(), fan.direction[a] + i);
    const Azimuths at = azimuths(f, direction);
    const Floats slope = hn::GatherIndex(F(), slopes, hn::BitCast(I(), at.sector));
    clear.add_word(i / 64, bits_of(is_above(at, slope, never)) << (i % 64));
  }
  return clear & fan.live;
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
