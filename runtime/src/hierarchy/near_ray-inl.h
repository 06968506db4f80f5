// Making near rays.
#if defined(VCD_RUNTIME_HIERARCHY_NEAR_RAY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_HIERARCHY_NEAR_RAY_INL_H
#undef VCD_RUNTIME_HIERARCHY_NEAR_RAY_INL_H
#else
#define VCD_RUNTIME_HIERARCHY_NEAR_RAY_INL_H
#endif

#include "hierarchy/near_ray.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The interval in which the line is in the box is wrong by less than 8 u · 9 M times the reciprocal, since the origin
// is within 8 M of the frame's. So the box is grown by 2^-16 M.
HWY_INLINE Nearness make_near_ray(const Traced& object, const Segment& segment, NearRay& ray) {
  const hn::FixedTag<float, 4> d;
  if (!(segment.t_min < segment.t_max)) return Nearness::misses;
  const float reach = object.reach;
  const auto three = hn::FirstN(d, 3);
  const auto given = hn::LoadU(d, segment.direction);  // and t_max
  const auto size = hn::IfThenElseZero(three, hn::Abs(given));
  const float length = hn::GetLane(hn::MaxOfLanes(d, size));
  // Written so that a NaN fails.
  if (!hn::AllTrue(d, hn::Le(size, hn::Set(d, 0x1p60f))) || !(length >= 0x1p-60f)) return Nearness::far;

  auto origin = hn::IfThenElseZero(three, hn::LoadU(d, segment.origin));
  float base = 0;  // the origin's t
  const bool is_own = hn::AllTrue(d, hn::Le(hn::Abs(origin), hn::Set(d, 8 * reach)));
  if (HWY_UNLIKELY(!is_own)) {
    if (!hn::AllTrue(d, hn::Le(hn::Abs(origin), hn::Set(d, 0x1p20f * reach)))) return Nearness::far;
    const Base nearest = far_base(object, segment);
    base = nearest.t;
    origin = hn::IfThenElseZero(three, hn::LoadU(d, nearest.origin));
    if (!hn::AllTrue(d, hn::Le(hn::Abs(origin), hn::Set(d, 8 * reach)))) return Nearness::misses;
  }
  // The two divisions do not wait for one another.
  const auto longest = hn::Ge(size, hn::Set(d, length));
  const auto sign = hn::And(given, hn::Set(d, -0.0f));  // Clang 14 loses CopySign() of a constant
  const auto steep = hn::Div(hn::Set(d, length), hn::Max(size, hn::Set(d, 0x1p-40f * length)));
  const auto shallow = hn::Max(hn::Mul(size, hn::Set(d, 1 / length)), hn::Set(d, 0x1p-40f));
  const auto direction = hn::Or(hn::IfThenElse(longest, hn::Set(d, 1.0f), shallow), sign),
             reciprocal = hn::Or(steep, sign);

  const float scale = reach + hn::GetLane(hn::MaxOfLanes(d, hn::Abs(origin))), outside = 4 * scale;  // S
  ray.first = std::max((segment.t_min - base) * length, -outside);
  ray.last = std::min((segment.t_max - base) * length, outside);
  ray.first_error = 0x1p-22f * std::abs(ray.first), ray.last_error = 0x1p-22f * std::abs(ray.last);
  const auto low = hn::Mul(hn::Sub(hn::LoadU(d, object.min), origin), reciprocal),
             high = hn::Mul(hn::Sub(hn::LoadU(d, object.max), origin), reciprocal);
  const auto room = hn::Set(d, 0x1p-16f * reach);
  const auto near = hn::IfThenElse(three, hn::NegMulAdd(room, steep, hn::Min(low, high)), hn::Set(d, ray.first)),
             far = hn::IfThenElse(three, hn::MulAdd(room, steep, hn::Max(low, high)), hn::Set(d, ray.last));
  const float enter = hn::GetLane(hn::MaxOfLanes(d, near)), leave = hn::GetLane(hn::MinOfLanes(d, far));
  if (!(enter <= leave)) return Nearness::misses;

  ray.slack = 0x1p-20f * scale;
  ray.origin_error = is_own ? 0 : 0x1p-23f * scale;
  ray.s_begin = enter - 2 * ray.slack, ray.s_end = leave + 2 * ray.slack;
  const auto product = hn::Mul(origin, reciprocal), grow = hn::Mul(hn::Set(d, ray.slack), steep);
  hn::Store(origin, d, ray.origin);
  hn::Store(direction, d, ray.direction);
  hn::Store(reciprocal, d, ray.reciprocal);
  hn::Store(hn::Add(product, grow), d, ray.enter);
  hn::Store(hn::Sub(product, grow), d, ray.leave);
  const hn::RebindToUnsigned<decltype(d)> words;
  const auto planes = hn::Mul(hn::Iota(words, 0), hn::Set(words, kNodeWidth));
  const auto negative = hn::VecFromMask(words, hn::RebindMask(words, hn::Lt(direction, hn::Zero(d))));
  hn::Store(hn::Add(planes, hn::And(negative, hn::Set(words, 3 * kNodeWidth))), words, ray.near_plane);
  static constexpr uint8_t kOthers[3][2] = {{1, 2}, {2, 0}, {0, 1}};
  ray.main = static_cast<uint32_t>(hn::FindFirstTrue(d, longest));
  ray.others[0] = kOthers[ray.main][0], ray.others[1] = kOthers[ray.main][1];
  return Nearness::near;
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
