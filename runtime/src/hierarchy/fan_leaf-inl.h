// A leaf's triangles against samples that are seen from one point.
#if defined(VCD_RUNTIME_HIERARCHY_FAN_LEAF_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_HIERARCHY_FAN_LEAF_INL_H
#undef VCD_RUNTIME_HIERARCHY_FAN_LEAF_INL_H
#else
#define VCD_RUNTIME_HIERARCHY_FAN_LEAF_INL_H
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "hierarchy/fan.h"
#include "hierarchy/leaf_vertices-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Of one axis and sign. The place of a sample is (x, y) / z of its direction, where z is along the axis.
struct FanPlane {
  std::array<size_t, 3> axis;                          // of x, y and z
  float sign;                                          // of z
  float origin[3];                                     // x, y, z; z times the sign
  float u_min, u_max, v_min, v_max, u_scale, v_scale;  // of the samples; and to 0 … 255
  float step;                                          // of both, at least
  float spread;                                        // the greatest |u| or |v|, at least 1
  float farthest;                                      // z of the farthest sample
};

// As many samples as are traced together at most.
inline constexpr size_t kFanSamples = 128;

// Those near enough to the plane's axis.
template <size_t kMost>
struct FanSamples {
  size_t count;
  alignas(64) float u[kMost], v[kMost], inverse_end[kMost];  // 1 / z of the direction
  alignas(64) int32_t number[kMost];                         // in the fan
  alignas(64) uint8_t u_step[kMost], v_step[kMost];          // of the samples' extent
};

// Where a leaf's box is seen, and E and E' below.
struct SeenBox {
  float u_min, u_max, v_min, v_max, edge, depth;
};

// A leaf's vertices from the point, around the place (u, v): x' = x - u z, y' = y - v z and z.
template <uint32_t kVertices>
struct SeenVertices {
  LeafVertices<kVertices> x, y, z;
};
template <uint32_t kVertices>
HWY_INLINE SeenVertices<kVertices> see(const HierarchyLeaf<kVertices>& leaf, const FanPlane& plane, float u, float v) {
  const FloatTag d;
  const auto [x_axis, y_axis, z_axis] = plane.axis;
  SeenVertices<kVertices> seen;
  for (size_t i = 0; i < kVertices; i += hn::Lanes(d)) {
    const auto z =
        hn::MulSub(hn::Load(d, leaf.vertex[z_axis] + i), hn::Set(d, plane.sign), hn::Set(d, plane.origin[2]));
    const auto from_origin = [&](size_t axis, size_t k) HWY_ATTR {
      return hn::Sub(hn::Load(d, leaf.vertex[axis] + i), hn::Set(d, plane.origin[k]));
    };
    seen.z.set(i, z);
    seen.x.set(i, hn::NegMulAdd(hn::Set(d, u), z, from_origin(x_axis, 0)));
    seen.y.set(i, hn::NegMulAdd(hn::Set(d, v), z, from_origin(y_axis, 1)));
  }
  return seen;
}

// On which side of an edge a sample passes is the sign of a function that is affine in its place. Of each triangle
// three such functions, around (u0, v0), and det, the sum of each times z of the corner that is not on its edge.
//
// Errors, for vertices whose coordinates, less the origin, are at most m, seen around a middle (u0, v0) within κ: so
// that x' = x - u0 z is at most κ m. Samples are within κ too: in the leaf's rectangle or less than a step beside it.
// U is the spread; |u0| <= U, κ <= U + 2; u = 2^-24.
//   x', y': u m (1 + |u0| + κ) <= u m (3 + 3 U) = ε                             z: u m
//   a side's slopes, y' z - z y':   2 (κ m u m + m ε) + 4 u κ m²                 = u m² (6 κ + 6 + 6 U)
//   its constant, x' y' - y' x':    4 κ m ε + 4 u κ² m²                          = u m² (12 κ (1 + U) + 4 κ²)
//   the sample's place:             (3 U + κ) u, times slopes 4 κ m²;  the sum's rounding: 12 u κ² m²
//   together: E = u m² κ (24 + 36 U + 32 κ);  det, likewise: E' = 36 u m³ κ (1 + U + κ)
// Around the sample itself a side is its constant alone:
//   with the sample's place: 4 κ m (ε + 3 U u m) + 4 u κ² m² = u m² (12 κ + 24 U κ + 4 κ²) < E
//   det: three times m times that, and 6 u κ² m³; its rounding 18 u κ² m³: u m³ κ (36 + 72 U + 36 κ) < 2 E'
// z of the hit is det / Σ sides: before the end if Σ - det / end > 4 E + E' / end (there 2 E'), and 24 u κ² m² < E for
// its rounding. A quarter more covers what is of second order, and 2^-110 what underflows.
//
// For boxes, one a lane. m: as above; width: of the rectangle, in which (u0, v0) lies unless it is wider than the
// spread and 1: then (u0, v0) is 0, or the sample.
HWY_INLINE void store_errors(hn::Vec<FloatTag> m, hn::Vec<FloatTag> width, const FanPlane& plane, float* edge,
                             float* depth) {
  const FloatTag d;
  constexpr float kUnit = 1.25f * 0x1p-24f;
  const float spread = plane.spread;
  const auto all = [](float x) HWY_ATTR { return hn::Set(FloatTag(), x); };
  const auto around = hn::MulAdd(hn::Min(width, all(1 + spread)), all(1 + 0x1p-20f), all(plane.step * (1 + 0x1p-20f)));
  const auto common = hn::Mul(hn::Mul(m, m), hn::Mul(around, all(kUnit)));
  hn::Store(hn::MulAdd(common, hn::MulAdd(around, all(32), all(24 + 36 * spread)), all(0x1p-110f)), d, edge);
  hn::Store(hn::MulAdd(hn::Mul(common, m), hn::MulAdd(around, all(36), all(36 + 36 * spread)), all(0x1p-110f)), d,
            depth);
}

// Those of `asked` that a triangle meets: each sample by itself, a vector of triangles at a time. Without branches, but
// for the number of samples: that they are hit is hard to predict. decide(triangles, sample) says of a sample whether
// it meets one of the triangles, a bit each, exactly.
template <uint32_t kVertices, size_t kMost, class Decide>
HWY_INLINE BitSet<kMost> hit_alone(const HierarchyLeaf<kVertices>& leaf, const FanPlane& plane, const SeenBox& box,
                                   const FanSamples<kMost>& samples, const BitSet<kMost>& asked, const Decide& decide) {
  const FloatTag d;
  const auto edge = hn::Set(d, box.edge), depth = hn::Set(d, 2 * box.depth);
  BitSet<kMost> hit{}, doubtful{};
  for (size_t s : asked) {
    const SeenVertices<kVertices> seen = see(leaf, plane, samples.u[s], samples.v[s]);
    const auto inverse_end = hn::Set(d, samples.inverse_end[s]);
    uint32_t met = 0, left = 0;
    for (size_t i = 0; i < kNodeWidth; i += hn::Lanes(d)) {
      hn::Vec<FloatTag> x[3], y[3], z[3], side[3];
      for (size_t k = 0; k < 3; ++k) {
        const auto corner = corner_indices(leaf.corner[k] + i);
        x[k] = seen.x.at(corner), y[k] = seen.y.at(corner), z[k] = seen.z.at(corner);
      }
      for (size_t k = 0; k < 3; ++k) side[k] = hn::MulSub(x[k], y[(k + 1) % 3], hn::Mul(y[k], x[(k + 1) % 3]));
      const auto least = hn::Min(side[0], hn::Min(side[1], side[2])),
                 most = hn::Max(side[0], hn::Max(side[1], side[2]));
      const auto total = hn::Add(side[0], hn::Add(side[1], side[2])), sign = hn::And(total, hn::Set(d, -0.0f));
      const auto det = hn::Xor(hn::MulAdd(z[2], side[0], hn::MulAdd(z[0], side[1], hn::Mul(z[1], side[2]))), sign);
      const auto before = hn::NegMulAdd(det, inverse_end, hn::Abs(total)),
                 room = hn::MulAdd(inverse_end, depth, hn::Set(d, 5 * box.edge));
      const auto possible = hn::Or(hn::Ge(least, hn::Neg(edge)), hn::Le(most, edge));
      const auto inside = hn::Or(hn::Ge(least, edge), hn::Le(most, hn::Neg(edge)));
      const auto is_hit = hn::And(hn::Gt(det, depth), hn::Ge(before, room));
      const auto is_missed = hn::Or(hn::Lt(det, hn::Neg(depth)), hn::Lt(before, hn::Neg(room)));
      met |= lane_bits(d, hn::And(inside, is_hit)) << i;
      left |= lane_bits(d, hn::AndNot(hn::And(inside, hn::Or(is_hit, is_missed)), possible)) << i;
    }
    hit.set(s, (met & leaf.present) != 0);
    doubtful.set(s, (left & leaf.present) != 0);
  }
  for (size_t s : doubtful.without(hit)) hit.set(s, decide(leaf.present, s));
  return hit;
}

// The sides of a leaf's triangles, times the sign of det: so all are positive at a hit.
struct Sides {
  alignas(64) float u_slope[3][kNodeWidth], v_slope[3][kNodeWidth], constant[3][kNodeWidth], det[kNodeWidth];
  float u0, v0;
  uint32_t possible;       // triangles that a sample may meet
  uint32_t flat, negated;  // those of which the sign of det is not certain; those of which it is negative
};

// The sign of det in doubles, where that is certain: wrong by less than 36 · 2^-53 m³, where m is the triangle's
// greatest coordinate, and 2^-47 m³ with what is of second order. Its size stays the float's.
template <uint32_t kVertices>
void settle_flat(const HierarchyLeaf<kVertices>& leaf, const FanPlane& plane, Sides& sides) {
  for (uint32_t rest = sides.flat & sides.possible; rest != 0; rest &= rest - 1) {
    const auto t = static_cast<size_t>(std::countr_zero(rest));
    double corner[3][3], m = 0;
    for (size_t k = 0; k < 3; ++k)
      for (size_t a = 0; a < 3; ++a) {
        corner[k][a] = double{leaf.vertex[plane.axis[a]][leaf.corner[k][t] % kVertices]} * (a == 2 ? plane.sign : 1) -
                       plane.origin[a];
        m = std::max(m, std::abs(corner[k][a]));
      }
    double det = 0;
    for (size_t k = 0; k < 3; ++k)
      det += corner[2][k] *
             (corner[0][(k + 1) % 3] * corner[1][(k + 2) % 3] - corner[0][(k + 2) % 3] * corner[1][(k + 1) % 3]);
    if (!(std::abs(det) > 0x1p-47 * m * m * m + 0x1p-300)) continue;
    sides.flat &= ~(1u << t);
    if ((det < 0) == (sides.negated >> t & 1)) continue;
    for (size_t k = 0; k < 3; ++k)
      for (float* side : {sides.u_slope[k], sides.v_slope[k], sides.constant[k]}) side[t] = -side[t];
  }
}

// A triangle whose det is beyond E' is met, if at all, where all its sides have det's sign. It is possible only if each
// of them is above -E somewhere in the rectangle of the leaf and of the samples: in floats, above -2 E.
template <uint32_t kVertices>
HWY_INLINE void make_sides(const HierarchyLeaf<kVertices>& leaf, const FanPlane& plane, const SeenBox& box,
                           Sides& sides) {
  const FloatTag d;
  const float u_low = std::max(box.u_min, plane.u_min), u_high = std::min(box.u_max, plane.u_max),
              v_low = std::max(box.v_min, plane.v_min), v_high = std::min(box.v_max, plane.v_max);
  const bool is_small = std::max(box.u_max - box.u_min, box.v_max - box.v_min) < 1 + plane.spread;
  const float u0 = is_small ? 0.5f * (u_low + u_high) : 0, v0 = is_small ? 0.5f * (v_low + v_high) : 0;
  sides.u0 = u0, sides.v0 = v0;

  const SeenVertices<kVertices> seen = see(leaf, plane, u0, v0);
  const auto u_reach = hn::Set(d, std::max(u_high - u0, u0 - u_low)),
             v_reach = hn::Set(d, std::max(v_high - v0, v0 - v_low)), limit = hn::Set(d, -2 * box.edge);
  sides.possible = sides.flat = sides.negated = 0;
  for (size_t i = 0; i < kNodeWidth && leaf.present >> i != 0; i += hn::Lanes(d)) {
    hn::Vec<FloatTag> x[3], y[3], z[3], u_slope[3], v_slope[3], constant[3];
    for (size_t k = 0; k < 3; ++k) {
      const auto corner = corner_indices(leaf.corner[k] + i);
      x[k] = seen.x.at(corner), y[k] = seen.y.at(corner), z[k] = seen.z.at(corner);
    }
    for (size_t k = 0; k < 3; ++k) {
      const size_t n = (k + 1) % 3;
      u_slope[k] = hn::MulSub(y[k], z[n], hn::Mul(z[k], y[n]));
      v_slope[k] = hn::MulSub(z[k], x[n], hn::Mul(x[k], z[n]));
      constant[k] = hn::MulSub(x[k], y[n], hn::Mul(y[k], x[n]));
    }
    const auto det = hn::MulAdd(x[2], u_slope[0], hn::MulAdd(y[2], v_slope[0], hn::Mul(z[2], constant[0])));
    const auto sign = hn::And(det, hn::Set(d, -0.0f)), size = hn::Xor(det, sign);
    const auto flat = hn::Le(size, hn::Set(d, box.depth));
    hn::Store(size, d, sides.det + i);
    auto positive = hn::Ge(size, hn::Zero(d)), negative = flat;  // no NaN comes here: see FanTracer::is_trusted()
    for (size_t k = 0; k < 3; ++k) {
      const auto c = hn::Xor(constant[k], sign);
      hn::Store(hn::Xor(u_slope[k], sign), d, sides.u_slope[k] + i);
      hn::Store(hn::Xor(v_slope[k], sign), d, sides.v_slope[k] + i);
      hn::Store(c, d, sides.constant[k] + i);
      const auto reach = hn::MulAdd(hn::Abs(u_slope[k]), u_reach, hn::Mul(hn::Abs(v_slope[k]), v_reach));
      positive = hn::And(positive, hn::Ge(hn::Add(c, reach), limit));
      negative = hn::And(negative, hn::Le(hn::Sub(c, reach), hn::Neg(limit)));
    }
    sides.flat |= lane_bits(d, flat) << i;
    sides.negated |= lane_bits(d, hn::Lt(det, hn::Zero(d))) << i;
    sides.possible |= lane_bits(d, hn::Or(positive, negative)) << i;
  }
  sides.possible &= leaf.present;
  if (HWY_UNLIKELY((sides.flat & sides.possible) != 0)) settle_flat(leaf, plane, sides);
}

// Of triangles, a lane each, or of one.
struct SideLanes {
  hn::Vec<FloatTag> u_slope[3], v_slope[3], constant[3], size;  // of det

  template <class Take>
  static HWY_INLINE SideLanes of(const Sides& sides, const Take& take) {
    return {{take(sides.u_slope[0]), take(sides.u_slope[1]), take(sides.u_slope[2])},
            {take(sides.v_slope[0]), take(sides.v_slope[1]), take(sides.v_slope[2])},
            {take(sides.constant[0]), take(sides.constant[1]), take(sides.constant[2])},
            take(sides.det)};
  }
};
// What is certain of a triangle and a sample, in each lane one of either.
struct Judged {
  uint32_t hit, doubtful;
};
// A bit for each lane: those to judge, and those that are flat. u and v less the middle's. rarely: a lane is possible.
template <bool kRarely>
HWY_INLINE Judged judge(const SideLanes& sides, const SeenBox& box, hn::Vec<FloatTag> u, hn::Vec<FloatTag> v,
                        hn::Vec<FloatTag> inverse_end, uint32_t asked, uint32_t flat) {
  const FloatTag d;
  const auto side = [&](size_t k) HWY_ATTR {
    return hn::MulAdd(sides.u_slope[k], u, hn::MulAdd(sides.v_slope[k], v, sides.constant[k]));
  };
  const auto a = side(0), b = side(1), c = side(2);
  const auto edge = hn::Set(d, box.edge), least = hn::Min(a, hn::Min(b, c));
  uint32_t possible = lane_bits(d, hn::Ge(least, hn::Neg(edge)));
  if (HWY_UNLIKELY(flat != 0)) possible |= flat & lane_bits(d, hn::Le(hn::Max(a, hn::Max(b, c)), edge));
  possible &= asked;
  if (kRarely && possible == 0) return {0, 0};
  const auto before = hn::NegMulAdd(sides.size, inverse_end, hn::Add(a, hn::Add(b, c))),
             room = hn::MulAdd(inverse_end, hn::Set(d, box.depth), hn::Set(d, 5 * box.edge));
  const uint32_t inside = possible & ~flat & lane_bits(d, hn::Ge(least, edge));
  const uint32_t hit = inside & lane_bits(d, hn::Ge(before, room));
  return {hit, possible & ~hit & ~(inside & lane_bits(d, hn::Lt(before, hn::Neg(room))))};
}

// The same as hit_alone(), by the sides: each triangle by itself, a vector of samples at a time.
template <size_t kMost, class Decide>
HWY_INLINE BitSet<kMost> hit_by_each(const Sides& sides, const SeenBox& box, const FanSamples<kMost>& samples,
                                     const BitSet<kMost>& asked, const Decide& decide) {
  const FloatTag d;
  const auto u0 = hn::Set(d, sides.u0), v0 = hn::Set(d, sides.v0);
  BitSet<kMost> hit{};
  for (size_t i = 0; i < samples.count; i += hn::Lanes(d)) {
    const auto all = static_cast<uint32_t>(asked.run(i / kRun) >> i % kRun) & ((1u << hn::Lanes(d)) - 1);
    if (all == 0) continue;
    const auto u = hn::Sub(hn::Load(d, samples.u + i), u0), v = hn::Sub(hn::Load(d, samples.v + i), v0),
               inverse_end = hn::Load(d, samples.inverse_end + i);
    uint32_t left = all;
    for (uint32_t rest = sides.possible; rest != 0 && left != 0; rest &= rest - 1) {
      const auto t = static_cast<size_t>(std::countr_zero(rest));
      const auto one = SideLanes::of(sides, [&](const float* array) HWY_ATTR { return hn::Set(d, array[t]); });
      auto [met, doubtful] = judge<true>(one, box, u, v, inverse_end, left, sides.flat >> t & 1 ? ~0u : 0);
      for (; HWY_UNLIKELY(doubtful != 0); doubtful &= doubtful - 1)
        if (const int s = std::countr_zero(doubtful); decide(1u << t, i + static_cast<size_t>(s))) met |= 1u << s;
      left &= ~met;
    }
    hit.add_run(i / kRun, uint64_t{all & ~left} << i % kRun);
  }
  return hit;
}

// The same, each sample by itself, a vector of triangles at a time.
template <size_t kMost, class Decide>
HWY_INLINE BitSet<kMost> each_that_is_hit(const Sides& sides, const SeenBox& box, const FanSamples<kMost>& samples,
                                          const BitSet<kMost>& asked, const Decide& decide) {
  const FloatTag d;
  BitSet<kMost> hit{}, doubtful{};
  for (size_t i = 0; i < kNodeWidth && sides.possible >> i != 0; i += hn::Lanes(d)) {
    const auto some = SideLanes::of(sides, [&](const float* array) HWY_ATTR { return hn::Load(d, array + i); });
    const uint32_t all = (1u << hn::Lanes(d)) - 1, possible = sides.possible >> i & all, flat = sides.flat >> i & all;
    for (size_t s : asked) {
      const Judged judged =
          judge<false>(some, box, hn::Set(d, samples.u[s] - sides.u0), hn::Set(d, samples.v[s] - sides.v0),
                       hn::Set(d, samples.inverse_end[s]), possible, flat);
      hit.set(s, judged.hit != 0);
      doubtful.set(s, judged.doubtful != 0);
    }
  }
  for (size_t s : doubtful.without(hit)) hit.set(s, decide(sides.possible, s));
  return hit;
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
