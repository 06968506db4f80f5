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

// As many samples as are traced together.
inline constexpr size_t kFanSamples = 128;
using FanBits = BitSet<kFanSamples>;

// Those near enough to the plane's axis; before they are packed, at their places in the fan.
struct FanSamples {
  size_t count;
  alignas(64) float u[kChunk], v[kChunk], inverse_end[kChunk];   // 1 / z of the direction
  alignas(64) int32_t number[kChunk];                            // in the fan
  alignas(64) uint8_t u_step[kFanSamples], v_step[kFanSamples];  // of the samples' extent
};

// A leaf's box: where it is seen, and its greatest coordinate less the origin's.
struct SeenBox {
  float u_min, u_max, v_min, v_max, farthest;
};

// On which side of an edge a sample passes is the sign of a function that is affine in its place. Of each triangle
// three such functions, around (u0, v0), times the sign of det: so all are positive at a hit.
struct Sides {
  alignas(64) float u_slope[3][kNodeWidth], v_slope[3][kNodeWidth], constant[3][kNodeWidth], det[kNodeWidth];
  float u0, v0;
  float edge, depth;       // E and E'
  uint32_t possible;       // triangles that a sample may meet
  uint32_t flat, negated;  // those of which the sign of det is not certain; those of which it is negative
};

// The sign of det in doubles, where that is certain: wrong by less than 36 · 2^-53 m³, and 2^-47 m³ with what is of
// second order. Its size stays the float's.
template <uint32_t kVertices>
void settle_flat(const HierarchyLeaf<kVertices>& leaf, const FanPlane& plane, float m, Sides& sides) {
  for (uint32_t rest = sides.flat & sides.possible; rest != 0; rest &= rest - 1) {
    const auto t = static_cast<size_t>(std::countr_zero(rest));
    double corner[3][3];
    for (size_t k = 0; k < 3; ++k)
      for (size_t a = 0; a < 3; ++a)
        corner[k][a] = double{leaf.vertex[plane.axis[a]][leaf.corner[k][t] % kVertices]} * (a == 2 ? plane.sign : 1) -
                       plane.origin[a];
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

// Errors, for vertices whose coordinates, less the origin, are at most m, seen around a middle (u0, v0) within κ: so
// that x' = x - u0 z is at most κ m. Samples are within κ too: in the leaf's rectangle or less than a step beside it.
// U is the spread; |u0| <= U, κ <= U + 2; u = 2^-24.
//   x', y': u m (1 + |u0| + κ) <= u m (3 + 3 U) = ε                             z: u m
//   a side's slopes, y' z - z y':   2 (κ m u m + m ε) + 4 u κ m²                 = u m² (6 κ + 6 + 6 U)
//   its constant, x' y' - y' x':    4 κ m ε + 4 u κ² m²                          = u m² (12 κ (1 + U) + 4 κ²)
//   the sample's place:             (3 U + κ) u, times slopes 4 κ m²;  the sum's rounding: 12 u κ² m²
//   together: E = u m² κ (24 + 36 U + 32 κ);  det, likewise: E' = 36 u m³ κ (1 + U + κ)
// z of the hit is det / Σ sides: before the end if Σ - det / end > 4 E + E' / end, and 24 u κ² m² < E for its rounding.
// A quarter more covers what is of second order, and 2^-110 what underflows.
//
// A triangle whose det is beyond E' is met, if at all, where all its sides have det's sign. It is possible only if each
// of them is above -E somewhere in the rectangle of the leaf and of the samples: in floats, above -2 E.
template <uint32_t kVertices>
HWY_INLINE void make_sides(const HierarchyLeaf<kVertices>& leaf, const FanPlane& plane, const SeenBox& box,
                           Sides& sides) {
  const FloatTag d;
  const auto [x_axis, y_axis, z_axis] = plane.axis;
  const float m = box.farthest, spread = plane.spread;
  const float u_low = std::max(box.u_min, plane.u_min), u_high = std::min(box.u_max, plane.u_max),
              v_low = std::max(box.v_min, plane.v_min), v_high = std::min(box.v_max, plane.v_max);
  float u0 = 0.5f * (u_low + u_high), v0 = 0.5f * (v_low + v_high);
  float around = std::max({u0 - box.u_min, box.u_max - u0, v0 - box.v_min, box.v_max - v0});
  if (!(around < 1 + spread)) u0 = v0 = 0, around = 1 + spread;
  around = (around + plane.step) * (1 + 0x1p-20f);
  constexpr float kUnit = 1.25f * 0x1p-24f;
  sides.u0 = u0, sides.v0 = v0;
  sides.edge = kUnit * m * m * around * (24 + 36 * spread + 32 * around) + 0x1p-110f;
  sides.depth = kUnit * 36 * m * m * m * around * (1 + spread + around) + 0x1p-110f;

  LeafVertices<kVertices> xs, ys, zs;
  for (size_t i = 0; i < kVertices; i += hn::Lanes(d)) {
    const auto z =
        hn::MulSub(hn::Load(d, leaf.vertex[z_axis] + i), hn::Set(d, plane.sign), hn::Set(d, plane.origin[2]));
    zs.set(i, z);
    xs.set(i, hn::NegMulAdd(hn::Set(d, u0), z,
                            hn::Sub(hn::Load(d, leaf.vertex[x_axis] + i), hn::Set(d, plane.origin[0]))));
    ys.set(i, hn::NegMulAdd(hn::Set(d, v0), z,
                            hn::Sub(hn::Load(d, leaf.vertex[y_axis] + i), hn::Set(d, plane.origin[1]))));
  }
  const auto u_reach = hn::Set(d, std::max(u_high - u0, u0 - u_low)),
             v_reach = hn::Set(d, std::max(v_high - v0, v0 - v_low)), limit = hn::Set(d, -2 * sides.edge);
  sides.possible = sides.flat = sides.negated = 0;
  for (size_t i = 0; i < kNodeWidth && leaf.present >> i != 0; i += hn::Lanes(d)) {
    hn::Vec<FloatTag> x[3], y[3], z[3], u_slope[3], v_slope[3], constant[3];
    for (size_t k = 0; k < 3; ++k) {
      const auto corner = corner_indices(leaf.corner[k] + i);
      x[k] = xs.at(corner), y[k] = ys.at(corner), z[k] = zs.at(corner);
    }
    for (size_t k = 0; k < 3; ++k) {
      const size_t n = (k + 1) % 3;
      u_slope[k] = hn::MulSub(y[k], z[n], hn::Mul(z[k], y[n]));
      v_slope[k] = hn::MulSub(z[k], x[n], hn::Mul(x[k], z[n]));
      constant[k] = hn::MulSub(x[k], y[n], hn::Mul(y[k], x[n]));
    }
    const auto det = hn::MulAdd(x[2], u_slope[0], hn::MulAdd(y[2], v_slope[0], hn::Mul(z[2], constant[0])));
    const auto sign = hn::And(det, hn::Set(d, -0.0f)), size = hn::Xor(det, sign);
    const auto flat = hn::Le(size, hn::Set(d, sides.depth));
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
  if (HWY_UNLIKELY((sides.flat & sides.possible) != 0)) settle_flat(leaf, plane, m, sides);
}

// Of triangles, a lane each, or of one.
struct SideLanes {
  hn::Vec<FloatTag> u_slope[3], v_slope[3], constant[3], det;

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

// A bit for each lane: those to judge, and those that are flat. u and v less the middle's.
HWY_INLINE Judged judge(const SideLanes& sides, float edge, float depth, hn::Vec<FloatTag> u, hn::Vec<FloatTag> v,
                        hn::Vec<FloatTag> inverse_end, uint32_t asked, uint32_t flat) {
  const FloatTag d;
  const auto side = [&](size_t k) HWY_ATTR {
    return hn::MulAdd(sides.u_slope[k], u, hn::MulAdd(sides.v_slope[k], v, sides.constant[k]));
  };
  const auto a = side(0), b = side(1), c = side(2);
  const auto error = hn::Set(d, edge), least = hn::Min(a, hn::Min(b, c));
  uint32_t possible = lane_bits(d, hn::Ge(least, hn::Neg(error)));
  if (HWY_UNLIKELY(flat != 0)) possible |= flat & lane_bits(d, hn::Le(hn::Max(a, hn::Max(b, c)), error));
  possible &= asked;
  if (HWY_LIKELY(possible == 0)) return {0, 0};
  const auto inside = hn::Ge(least, error);
  const auto total = hn::Add(a, hn::Add(b, c));
  const auto before = hn::NegMulAdd(sides.det, inverse_end, total),
             room = hn::MulAdd(inverse_end, hn::Set(d, depth), hn::Set(d, 5 * edge));
  const uint32_t certain = possible & ~flat;
  const uint32_t hit = certain & lane_bits(d, hn::And(inside, hn::Ge(before, room)));
  const uint32_t missed = certain & lane_bits(d, hn::And(inside, hn::Lt(before, hn::Neg(room))));
  return {hit, possible & ~hit & ~missed};
}

// Those of `asked` that a triangle meets. A vector of samples at a time, and each triangle; decide(triangles, sample)
// says of a sample whether it meets one of the triangles, a bit each, exactly.
template <class Decide>
HWY_INLINE FanBits hit_by_each(const Sides& sides, const FanSamples& samples, const FanBits& asked,
                               const Decide& decide) {
  const FloatTag d;
  const auto u0 = hn::Set(d, sides.u0), v0 = hn::Set(d, sides.v0);
  FanBits hit{};
  for (size_t i = 0; i < samples.count; i += hn::Lanes(d)) {
    const auto all = static_cast<uint32_t>(asked.run(i / kRun) >> i % kRun) & ((1u << hn::Lanes(d)) - 1);
    if (all == 0) continue;
    const auto u = hn::Sub(hn::Load(d, samples.u + i), u0), v = hn::Sub(hn::Load(d, samples.v + i), v0),
               inverse_end = hn::Load(d, samples.inverse_end + i);
    uint32_t left = all;
    for (uint32_t rest = sides.possible; rest != 0 && left != 0; rest &= rest - 1) {
      const auto t = static_cast<size_t>(std::countr_zero(rest));
      const auto one = SideLanes::of(sides, [&](const float* array) HWY_ATTR { return hn::Set(d, array[t]); });
      auto [met, doubtful] =
          judge(one, sides.edge, sides.depth, u, v, inverse_end, left, sides.flat >> t & 1 ? ~0u : 0);
      for (; HWY_UNLIKELY(doubtful != 0); doubtful &= doubtful - 1)
        if (const int s = std::countr_zero(doubtful); decide(1u << t, i + static_cast<size_t>(s))) met |= 1u << s;
      left &= ~met;
    }
    hit.add_run(i / kRun, uint64_t{all & ~left} << i % kRun);
  }
  return hit;
}

// The same, a vector of triangles at a time, and each sample.
template <class Decide>
HWY_INLINE FanBits each_that_is_hit(const Sides& sides, const FanSamples& samples, const FanBits& asked,
                                    const Decide& decide) {
  const FloatTag d;
  FanBits hit{};
  for (size_t i = 0; i < kNodeWidth && sides.possible >> i != 0; i += hn::Lanes(d)) {
    const auto some = SideLanes::of(sides, [&](const float* array) HWY_ATTR { return hn::Load(d, array + i); });
    const uint32_t all = (1u << hn::Lanes(d)) - 1, possible = sides.possible >> i & all, flat = sides.flat >> i & all;
    const float edge = sides.edge, depth = sides.depth, u0 = sides.u0, v0 = sides.v0;
    for (size_t s : asked.without(hit)) {
      const Judged judged = judge(some, edge, depth, hn::Set(d, samples.u[s] - u0), hn::Set(d, samples.v[s] - v0),
                                  hn::Set(d, samples.inverse_end[s]), possible, flat);
      if (judged.hit != 0 || (HWY_UNLIKELY(judged.doubtful != 0) && decide(judged.doubtful << i, s))) hit.set(s);
    }
  }
  return hit;
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
