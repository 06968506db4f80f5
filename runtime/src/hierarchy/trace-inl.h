// Single segments through a hierarchy.
#if defined(VCD_RUNTIME_HIERARCHY_TRACE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_HIERARCHY_TRACE_INL_H
#undef VCD_RUNTIME_HIERARCHY_TRACE_INL_H
#else
#define VCD_RUNTIME_HIERARCHY_TRACE_INL_H
#endif

#include <bit>

#include <hwy/cache_control.h>

#include "hierarchy/leaf_vertices-inl.h"
#include "hierarchy/near_ray-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

// The children whose boxes the ray meets, a bit each.
HWY_INLINE uint32_t children_met(const HierarchyNode& node, const NearRay& ray) {
  const FloatTag d;
  hwy::Prefetch(node.child);  // needed as soon as the bits are known
  const float* const planes = &node.min[0][0];
  uint32_t met = 0;
  for (size_t i = 0; i < kNodeWidth; i += hn::Lanes(d)) {
    const auto near = [&](size_t a) HWY_ATTR {
      return hn::MulSub(hn::Load(d, planes + ray.near_plane[a] + i), hn::Set(d, ray.reciprocal[a]),
                        hn::Set(d, ray.enter[a]));
    };
    const auto far = [&](size_t a) HWY_ATTR {  // the planes on the other side
      return hn::MulSub(hn::Load(d, planes + (2 * a + 3) * kNodeWidth - ray.near_plane[a] + i),
                        hn::Set(d, ray.reciprocal[a]), hn::Set(d, ray.leave[a]));
    };
    const auto enter = hn::Max(hn::Max(near(0), near(1)), hn::Max(near(2), hn::Set(d, ray.s_begin)));
    const auto leave = hn::Min(hn::Min(far(0), far(1)), hn::Min(far(2), hn::Set(d, ray.s_end)));
    met |= lane_bits(d, hn::Le(enter, leave)) << i;
  }
  return met;
}

// Whether a triangle of the leaf meets the segment. The sides of a triangle's edges that the ray passes on are found in
// the frame in which the ray is the third axis (Woop, Benthin and Wald, "Watertight ray/triangle intersection", 2013);
// what is in doubt is decided exactly.
//
// Leaf errors. The line passes within 2 δ of the leaf's box, whose longest side is L, so that sheared coordinates are
// at most X = 2 L + 8 δ, and a vertex is within Z = |z of the first| + L + X of the origin. Where the origin is wrong
// by less than δ0, sheared coordinates are wrong by less than 2 δ0 + u (4 |z| + 3 X), less than δ' = 2 δ0 + 8 u Z. A
// side, C_x B_y - C_y B_x, is then wrong by less than 4 X δ' + 2 δ'² + 4 u X², less than E = 5 X δ' + 2 δ'². So much
// for the triangles that may be met; of each of those, X is the greatest of its own coordinates, and Z its greatest |z|
// and X, which makes δ' and E smaller. Where all three sides are beyond E, the hit's s is Σ side · z / Σ side. The
// weights are wrong by 6 E / |det| in all, which counts as much as the corners' z differ; z, and rounding, by less than
// 3 δ': in all 3 δ' |det| + 8 E (z_max - z_min), and 2^-120 for what underflows. No s of a triangle is beyond those of
// its corners.
template <uint32_t kVertices>
HWY_INLINE bool leaf_meets(const HierarchyLeaf<kVertices>& leaf, const NearRay& ray, const HierarchyView& view,
                           uint32_t child, const Segment& segment) {
  const FloatTag d;
  const auto [x_axis, y_axis, z_axis] = std::array{ray.others[0], ray.others[1], ray.main};
  const float sign = ray.direction[z_axis];
  const auto shear_x = hn::Set(d, ray.direction[x_axis] * sign), shear_y = hn::Set(d, ray.direction[y_axis] * sign);
  const auto x0 = hn::Set(d, ray.origin[x_axis]), y0 = hn::Set(d, ray.origin[y_axis]),
             z0 = hn::Set(d, ray.origin[z_axis]);
  LeafVertices<kVertices> x, y, z;
  for (size_t i = 0; i < kVertices; i += hn::Lanes(d)) {
    const auto height = hn::Sub(hn::Load(d, leaf.vertex[z_axis] + i), z0);
    z.set(i, height);
    x.set(i, hn::NegMulAdd(shear_x, height, hn::Sub(hn::Load(d, leaf.vertex[x_axis] + i), x0)));
    y.set(i, hn::NegMulAdd(shear_y, height, hn::Sub(hn::Load(d, leaf.vertex[y_axis] + i), y0)));
  }
  const float extent = leaf.extent, coordinate = 2 * extent + 8 * ray.slack;                                  // X
  const float reach = std::abs(leaf.vertex[z_axis][0] - ray.origin[z_axis]) + extent + coordinate;            // Z
  const float local = 2 * ray.origin_error + 0x1p-21f * reach, limit = local * (5 * coordinate + 2 * local);  // δ', E
  const auto error = hn::Set(d, limit), minus = hn::Set(d, -limit);
  uint32_t doubtful = 0;
  for (size_t i = 0; i < kNodeWidth; i += hn::Lanes(d)) {
    const auto a = corner_indices(leaf.corner[0] + i), b = corner_indices(leaf.corner[1] + i),
               c = corner_indices(leaf.corner[2] + i);
    const auto ax = x.at(a), ay = y.at(a), bx = x.at(b), by = y.at(b), cx = x.at(c), cy = y.at(c);
    const auto u = hn::MulSub(cx, by, hn::Mul(cy, bx)), v = hn::MulSub(ax, cy, hn::Mul(ay, cx)),
               w = hn::MulSub(bx, ay, hn::Mul(by, ax));
    const auto least = hn::Min(u, hn::Min(v, w)), most = hn::Max(u, hn::Max(v, w));
    const uint32_t present = leaf.present >> i & ((1u << hn::Lanes(d)) - 1);
    const uint32_t possible = lane_bits(d, hn::Or(hn::Ge(least, minus), hn::Le(most, error))) & present;
    if (HWY_LIKELY(possible == 0)) continue;
    const auto along = hn::Set(d, sign);
    const auto az = hn::Mul(z.at(a), along), bz = hn::Mul(z.at(b), along), cz = hn::Mul(z.at(c), along);
    const auto nearest = hn::Min(az, hn::Min(bz, cz)), farthest = hn::Max(az, hn::Max(bz, cz));
    const auto most_of = [&](auto p, auto q, auto o)
                             HWY_ATTR { return hn::Max(hn::Abs(p), hn::Max(hn::Abs(q), hn::Abs(o))); };
    const auto own = hn::Max(most_of(ax, bx, cx), most_of(ay, by, cy));  // X of the triangle, and so on
    const auto own_reach = hn::Add(own, hn::Max(hn::Abs(nearest), hn::Abs(farthest)));
    const auto own_local = hn::MulAdd(own_reach, hn::Set(d, 0x1p-21f), hn::Set(d, 2 * ray.origin_error));
    const auto own_limit = hn::Mul(own_local, hn::MulAdd(own, hn::Set(d, 5.0f), hn::Add(own_local, own_local)));
    const auto inside = hn::Or(hn::Ge(least, own_limit), hn::Le(most, hn::Neg(own_limit)));
    const auto det = hn::Add(u, hn::Add(v, w)), size = hn::Abs(det);
    const auto t = hn::Xor(hn::MulAdd(u, az, hn::MulAdd(v, bz, hn::Mul(w, cz))), hn::And(det, hn::Set(d, -0.0f)));
    const auto first = hn::Set(d, ray.first), last = hn::Set(d, ray.last);
    const auto after = hn::NegMulAdd(size, first, t), before = hn::MulSub(size, last, t);
    const auto wrong = hn::Mul(own_local, hn::Set(d, 3.0f));
    const auto wrong_first = hn::Add(wrong, hn::Set(d, ray.first_error)),
               wrong_last = hn::Add(wrong, hn::Set(d, ray.last_error));
    const auto by_weights =
        hn::MulAdd(hn::Mul(own_limit, hn::Set(d, 8.0f)), hn::Sub(farthest, nearest), hn::Set(d, 0x1p-120f));
    const auto room_first = hn::MulAdd(size, wrong_first, by_weights),
               room_last = hn::MulAdd(size, wrong_last, by_weights);
    const auto hit = hn::And(hn::Ge(after, room_first), hn::Ge(before, room_last));
    if (lane_bits(d, hn::And(inside, hit)) & possible) return true;
    const auto missed = hn::Or(hn::Lt(after, hn::Neg(room_first)), hn::Lt(before, hn::Neg(room_last)));
    const uint32_t left = possible & ~lane_bits(d, hn::And(inside, missed));
    if (HWY_LIKELY(left == 0)) continue;
    const auto outside =
        hn::Or(hn::Lt(hn::Add(farthest, wrong_first), first), hn::Gt(hn::Sub(nearest, wrong_last), last));
    doubtful |= (left & ~lane_bits(d, outside)) << i;
  }
  return HWY_UNLIKELY(doubtful != 0) && meets_some(view, child, doubtful, segment);
}

HWY_INLINE bool child_meets(const HierarchyView& view, uint32_t child, const NearRay& ray, const Segment& segment) {
  return child & kLargeChild ? leaf_meets(view.large_leaf(child), ray, view, child, segment)
                             : leaf_meets(view.small_leaf(child), ray, view, child, segment);
}

// Depth first; the children of a node in their order.
HWY_INLINE bool trace_from(const HierarchyView& view, uint32_t node, const NearRay& ray, const Segment& segment) {
  struct Rest {
    uint32_t node, met;
  };
  Rest stack[kMostLevels];
  uint32_t depth = 0;
  uint32_t met = children_met(view.node(node), ray);
  for (;;) {
    while (met == 0) {
      if (depth == 0) return false;
      node = stack[--depth].node, met = stack[depth].met;
    }
    const uint32_t* const children = view.node(node).child;
    const uint32_t child = children[std::countr_zero(met)];
    met &= met - 1;
    if (child & kLeafChild) {
      if (child_meets(view, child, ray, segment)) return true;
      continue;
    }
    if (met != 0) {
      const std::byte* const next = view.at(children[std::countr_zero(met)]);
      for (size_t unit = 0; unit < 4; ++unit) hwy::Prefetch(next + unit * kUnitBytes);
      stack[depth++] = {node, met};
    }
    node = child;
    met = children_met(view.node(node), ray);
  }
}

bool Occluded(const Traced& object, const Segment& segment) noexcept {
  NearRay ray;
  switch (make_near_ray(object, segment, ray)) {
    case Nearness::misses: return false;
    case Nearness::far: return occluded_scalar(object, segment);
    case Nearness::near: break;
  }
  return trace_from(object.view, kRootUnit, ray, segment);
}

bool OccludedLookedUp(const Traced& object, const LookUpOne& look_up, const Segment& segment) noexcept {
  NearRay ray;
  const Nearness nearness = make_near_ray(object, segment, ray);
  if (nearness == Nearness::misses) return false;
  const Visibility answer = look_up.classify(look_up.frame, look_up.tree, segment);
  if (answer != Visibility::unclassified) return answer == Visibility::blocked;
  return nearness == Nearness::far ? occluded_scalar(object, segment)
                                   : trace_from(object.view, kRootUnit, ray, segment);
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
