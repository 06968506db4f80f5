// Making near rays of many segments, one a lane.
#if defined(VCD_RUNTIME_HIERARCHY_NEAR_RAYS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_HIERARCHY_NEAR_RAYS_INL_H
#undef VCD_RUNTIME_HIERARCHY_NEAR_RAYS_INL_H
#else
#define VCD_RUNTIME_HIERARCHY_NEAR_RAYS_INL_H
#endif

#include "hierarchy/box_lanes-inl.h"
#include "hierarchy/near_ray-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

// kWidth rays, in parts of four floats.
class NearRays {
 public:
  // The same operations in the same order as make_near_ray(), a segment in each lane. Lanes that are neither near() nor
  // misses() are for make_near_ray() to decide.
  HWY_INLINE NearRays(const BoxLanes& box, const Lanes& lanes) {
    const Passage way = passage(box, lanes);
    const Truth some = hn::Lt(lanes.t_min, lanes.t_max), meets = hn::And(some, hn::Le(way.enter, way.leave));
    near_ = bits_of_lanes(hn::And(way.known, meets));
    misses_ = bits_of_lanes(hn::Or(hn::AndNot(meets, way.known), hn::Not(some)));
    if (near_ == 0) return;

    const Floats zero = hn::Zero(F()), one = all(1.0f);
    const Floats scale = hn::Add(box.reach, way.farthest), slack = hn::Mul(all(0x1p-20f), scale);
    const Floats shorter = hn::Div(one, way.length);
    Floats direction[3], enter[3], leave[3];
    Words plane[3];
    for (uint32_t a = 0; a < 3; ++a) {
      const Floats shallow = hn::Max(hn::Mul(way.size[a], shorter), all(0x1p-40f));
      direction[a] = hn::CopySign(hn::IfThenElse(hn::Ge(way.size[a], way.length), one, shallow), lanes.direction[a]);
      const Floats product = hn::Mul(lanes.origin[a], way.reciprocal[a]), grow = hn::Mul(slack, way.steep[a]);
      enter[a] = hn::Add(product, grow), leave[a] = hn::Sub(product, grow);
      const Words negative = hn::VecFromMask(U(), hn::RebindMask(U(), hn::Lt(direction[a], zero)));
      plane[a] = hn::Add(all(a * uint32_t{kNodeWidth}), hn::And(negative, all(3 * uint32_t{kNodeWidth})));
    }
    // The first of the longest axes.
    const auto words = [](Truth truth) HWY_ATTR { return hn::RebindMask(U(), truth); };
    const auto x_is = words(hn::Ge(way.size[0], way.length)), y_is = words(hn::Ge(way.size[1], way.length));
    const auto of_axis = [&](uint32_t x, uint32_t y, uint32_t z)
                             HWY_ATTR { return hn::IfThenElse(x_is, all(x), hn::IfThenElse(y_is, all(y), all(z))); };
    const auto floats = [](Words w) HWY_ATTR { return hn::BitCast(F(), w); };
    const auto error = [](Floats s) HWY_ATTR { return hn::Mul(all(0x1p-22f), hn::Abs(s)); };
    const Floats twice = hn::Add(slack, slack);
    put(0, lanes.origin[0], lanes.origin[1], lanes.origin[2], zero);
    put(1, direction[0], direction[1], direction[2], zero);
    put(2, way.reciprocal[0], way.reciprocal[1], way.reciprocal[2], zero);
    put(3, enter[0], enter[1], enter[2], zero);
    put(4, leave[0], leave[1], leave[2], zero);
    put(5, floats(plane[0]), floats(plane[1]), floats(plane[2]), zero);
    put(6, hn::Sub(way.enter, twice), hn::Add(way.leave, twice), way.first, way.last);
    put(7, error(way.first), error(way.last), slack, zero);
    put(8, floats(of_axis(0, 1, 2)), floats(of_axis(1, 2, 0)), floats(of_axis(2, 0, 1)), zero);
  }

  uint32_t near() const { return near_; }
  uint32_t misses() const { return misses_; }
  // lane: a near one.
  HWY_INLINE void store(size_t lane, NearRay& ray) const {
    const hn::FixedTag<float, 4> four;
    for (size_t part = 0; part < kParts; ++part)
      hn::Store(hn::Load(four, parts_[part] + 4 * lane), four, reinterpret_cast<float*>(&ray) + 4 * part);
  }

 private:
  static constexpr size_t kParts = 9;

  static HWY_INLINE uint32_t bits_of_lanes(Truth truth) {
    uint8_t bits[8] = {};
    hn::StoreMaskBits(F(), truth, bits);
    return bits[0] | uint32_t{bits[1]} << 8;
  }
  HWY_INLINE void put(size_t part, Floats a, Floats b, Floats c, Floats d) {
    hn::StoreInterleaved4(a, b, c, d, F(), parts_[part]);
  }

  uint32_t near_, misses_;
  HWY_ALIGN float parts_[kParts][4 * kWidth];
};

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
