// The same operations in the same order as clear_of_horizon(), a segment in each lane.
#if defined(VCD_RUNTIME_HORIZON_ABOVE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_HORIZON_ABOVE_INL_H
#undef VCD_RUNTIME_HORIZON_ABOVE_INL_H
#else
#define VCD_RUNTIME_HORIZON_ABOVE_INL_H
#endif

#include <algorithm>

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
