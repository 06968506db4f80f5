// Segments from one point through a hierarchy, together: bundles, and whatever else begins at one point.
//
// Seen from the point, along the axis that most of them follow, samples and boxes become points and rectangles of a
// plane. A node is visited if a rectangle of its children holds a sample that is not decided, and a leaf's triangles
// are tested against just those samples, as three functions of the place in the plane that are affine in it (Benthin
// and Wald, "Efficient ray traced soft shadows using multi-frusta tracing", 2009, do so with frusta).
#if defined(VCD_RUNTIME_HIERARCHY_FAN_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_HIERARCHY_FAN_INL_H
#undef VCD_RUNTIME_HIERARCHY_FAN_INL_H
#else
#define VCD_RUNTIME_HIERARCHY_FAN_INL_H
#endif

#include <array>
#include <bit>
#include <limits>

#include "hierarchy/fan_leaf-inl.h"
#include "hierarchy/trace-inl.h"
#include "lookup/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

// A direction must be no further from the plane's axis than this, as a tangent.
inline constexpr float kWidestTangent = 4;
// As few samples as these go on alone from a node, and are tested alone against a leaf.
inline constexpr int kFewOfNode = 2, kFewOfLeaf = 4;

// A node's children, as they are seen.
struct Children {
  alignas(64) float u_min[kNodeWidth], u_max[kNodeWidth], v_min[kNodeWidth], v_max[kNodeWidth];
  alignas(64) float edge[kNodeWidth], depth[kNodeWidth];  // errors of leaves: see SeenBox
  uint8_t u_first[kNodeWidth], u_last[kNodeWidth], v_first[kNodeWidth], v_last[kNodeWidth];  // steps

  SeenBox box(size_t i) const { return {u_min[i], u_max[i], v_min[i], v_max[i], edge[i], depth[i]}; }
};

// Of the lowest bits.
HWY_INLINE hn::Mask<FloatTag> mask_of(uint64_t bits) {
  const uint8_t bytes[8] = {static_cast<uint8_t>(bits), static_cast<uint8_t>(bits >> 8)};
  return hn::LoadMaskBits(FloatTag(), bytes);
}

// The steps of places from the first one on.
HWY_INLINE void store_steps(hn::Vec<FloatTag> at, float first, float scale, uint8_t* into) {
  const FloatTag d;
  const hn::Rebind<uint8_t, FloatTag> bytes;
  const hn::RebindToUnsigned<IndexTag> words;
  const auto steps = truncated(hn::Mul(hn::Sub(at, hn::Set(d, first)), hn::Set(d, scale)));
  hn::StoreU(hn::TruncateTo(bytes, hn::BitCast(words, steps)), bytes, into);
}

// Which children are leaves, a bit each.
HWY_INLINE uint32_t leaves_of(const HierarchyNode& node) {
  static_assert(kLeafChild == uint32_t{1} << 31);  // the sign
  const FloatTag d;
  uint32_t leaves = 0;
  for (size_t i = 0; i < kNodeWidth; i += hn::Lanes(d)) {
    const auto children = hn::Load(IndexTag(), reinterpret_cast<const int32_t*>(node.child) + i);
    leaves |= lane_bits(d, hn::RebindMask(d, hn::Lt(children, hn::Zero(IndexTag())))) << i;
  }
  return leaves;
}

template <size_t kMost>
class FanTracer {
 public:
  FanTracer(const Traced& object, const Fan& fan) : object_(object), fan_(fan) {}

  SampleBits blocked() {
    SampleBits blocked{}, left = fan_.live;
    const auto trace_alone = [&](const SampleBits& which) HWY_ATTR {
      for (size_t i : which) blocked.set(i, Occluded(object_, segment_of(fan_, i)));
      left = left.without(which);
    };
    while (left.any()) {
      if (left.count() <= kFewOfNode || !is_trusted()) {
        trace_alone(left);
        break;
      }
      const size_t first = left.lowest();
      const SampleBits taken = make_plane(left, first);
      if (!taken.any()) {
        trace_alone(SampleBits::just(first));
        continue;
      }
      const Bits all = Bits::first(samples_.count);
      live_ = all;
      trace(kRootUnit);
      if (is_packed_)
        for (size_t i : all.without(live_)) blocked.set(static_cast<size_t>(samples_.number[i]));
      else blocked.add(all.without(live_));
      left = left.without(taken);
    }
    return blocked;
  }

 private:
  using Bits = BitSet<kMost>;

  // Whether the errors below are bounded: 2^6 M is far from where products of three coordinates overflow.
  bool is_trusted() const {
    float farthest = 0;
    for (float x : fan_.origin) farthest += std::abs(x);
    const float reach = object_.reach;
    return reach >= 0x1p-20f && reach <= 0x1p30f && farthest <= 64 * reach;
  }

  Segment segment(size_t i) const { return segment_of(fan_, is_packed_ ? static_cast<size_t>(samples_.number[i]) : i); }

  // Takes the axis that sample `first` follows, and prepares those samples of `left` that are near enough to it, as
  // many as there is room for. Returns them; it may be that none is.
  SampleBits make_plane(const SampleBits& left, size_t first);
  // What of a node's children holds a sample that could be met, a bit each.
  uint32_t look(const HierarchyNode& node, Children& children) const;
  // Which of the children in `met` hold a sample that is not blocked, and which samples those are.
  uint32_t hold_samples(const Children& children, uint32_t met, Bits* within) const;
  template <uint32_t kVertices>
  void test(const HierarchyLeaf<kVertices>& leaf, uint32_t child, const SeenBox& box, const Bits& samples);
  void trace_from_each(uint32_t child, const Bits& samples);
  void trace(uint32_t root);

  const Traced& object_;
  const Fan& fan_;
  FanPlane plane_;
  FanSamples<kMost> samples_;
  bool is_packed_;  // or the samples are the fan's first
  Bits live_;       // of the samples: not blocked so far
};

template <size_t kMost>
SampleBits FanTracer<kMost>::make_plane(const SampleBits& left, size_t first) {
  const FloatTag d;
  size_t z = 0;
  for (size_t a = 1; a < 3; ++a)
    if (std::abs(fan_.direction[a][first]) > std::abs(fan_.direction[z][first])) z = a;
  plane_.sign = fan_.direction[z][first] < 0 ? -1.0f : 1.0f;
  plane_.axis = {(z + 1) % 3, (z + 2) % 3, z};
  for (size_t k = 0; k < 3; ++k) plane_.origin[k] = fan_.origin[plane_.axis[k]];
  plane_.origin[2] *= plane_.sign;

  SampleBits taken{};
  int count = 0;
  const float* const dx = fan_.direction[plane_.axis[0]];
  const float* const dy = fan_.direction[plane_.axis[1]];
  const float* const dz = fan_.direction[plane_.axis[2]];
  const auto big = hn::Set(d, std::numeric_limits<float>::max());
  auto u_min = big, v_min = big, u_max = hn::Neg(big), v_max = u_max, end_max = hn::Zero(d);
  for (size_t i = 0; i < fan_.count && count <= static_cast<int>(kMost - hn::Lanes(d)); i += hn::Lanes(d)) {
    constexpr uint32_t kAll = (1u << kFloatLanes) - 1;
    const uint32_t live = static_cast<uint32_t>(left.run(i / kRun) >> i % kRun) & kAll;
    if (live == 0) continue;
    const auto along = hn::Mul(hn::LoadU(d, dz + i), hn::Set(d, plane_.sign)), x = hn::LoadU(d, dx + i),
               y = hn::LoadU(d, dy + i), wide = hn::Mul(along, hn::Set(d, kWidestTangent));
    // NaN is not near.
    auto near = hn::And(hn::And(hn::Ge(along, hn::Set(d, 0x1p-60f)), hn::Le(along, hn::Set(d, 0x1p60f))),
                        hn::And(hn::Le(hn::Abs(x), wide), hn::Le(hn::Abs(y), wide)));
    if (live != kAll) near = hn::And(near, mask_of(live));
    const uint32_t bits = lane_bits(d, near);
    taken.add_run(i / kRun, uint64_t{bits} << i % kRun);
    const auto inverse = hn::Div(hn::Set(d, 1.0f), along), u = hn::Mul(x, inverse), v = hn::Mul(y, inverse);
    const auto at = static_cast<size_t>(count);
    const auto put = [&](auto values, float* into)
                         HWY_ATTR { hn::StoreU(bits == kAll ? values : hn::Compress(values, near), d, into + at); };
    put(u, samples_.u), put(v, samples_.v), put(inverse, samples_.inverse_end);
    const auto numbers = hn::Iota(IndexTag(), static_cast<int32_t>(i));
    hn::StoreU(bits == kAll ? numbers : hn::Compress(numbers, hn::RebindMask(IndexTag(), near)), IndexTag(),
               samples_.number + at);
    count += std::popcount(bits);
    u_min = hn::Min(u_min, hn::IfThenElse(near, u, big)), u_max = hn::Max(u_max, hn::IfThenElse(near, u, hn::Neg(big)));
    v_min = hn::Min(v_min, hn::IfThenElse(near, v, big)), v_max = hn::Max(v_max, hn::IfThenElse(near, v, hn::Neg(big)));
    end_max = hn::Max(end_max, hn::IfThenElseZero(near, along));
  }
  samples_.count = static_cast<size_t>(count);
  is_packed_ = !(taken == SampleBits::first(samples_.count));
  if (!taken.any()) return taken;
  plane_.u_min = hn::GetLane(hn::MinOfLanes(d, u_min)), plane_.u_max = hn::GetLane(hn::MaxOfLanes(d, u_max));
  plane_.v_min = hn::GetLane(hn::MinOfLanes(d, v_min)), plane_.v_max = hn::GetLane(hn::MaxOfLanes(d, v_max));
  plane_.farthest = hn::GetLane(hn::MaxOfLanes(d, end_max));
  plane_.spread =
      std::max({1.0f, std::abs(plane_.u_min), std::abs(plane_.u_max), std::abs(plane_.v_min), std::abs(plane_.v_max)});
  const auto scale = [](float extent) { return extent > 0x1p-60f ? 255 / extent : 0.0f; };
  plane_.u_scale = scale(plane_.u_max - plane_.u_min), plane_.v_scale = scale(plane_.v_max - plane_.v_min);
  plane_.step = std::max(plane_.u_max - plane_.u_min, plane_.v_max - plane_.v_min) * (1.01f / 255);
  for (size_t i = 0; i < samples_.count; i += hn::Lanes(d)) {
    store_steps(hn::Load(d, samples_.u + i), plane_.u_min, plane_.u_scale, samples_.u_step + i);
    store_steps(hn::Load(d, samples_.v + i), plane_.v_min, plane_.v_scale, samples_.v_step + i);
  }
  return taken;
}

// A place is wrong by less than 3 u · 4, a rectangle's side by less than 4 u of itself (u = 2^-24). Sides within ±8 are
// moved outwards by 2^-18, and no sample is near others, so none that could be met is missed. Steps are found by the
// same operations for samples and for sides, which never exchange two that are in order.
template <size_t kMost>
HWY_INLINE uint32_t FanTracer<kMost>::look(const HierarchyNode& node, Children& c) const {
  const FloatTag d;
  const auto [x_axis, y_axis, z_axis] = plane_.axis;
  const float* const z_near = plane_.sign > 0 ? node.min[z_axis] : node.max[z_axis];
  const float* const z_far = plane_.sign > 0 ? node.max[z_axis] : node.min[z_axis];
  const auto sign = hn::Set(d, plane_.sign), zero = hn::Zero(d), one = hn::Set(d, 1.0f),
             infinite = hn::Set(d, std::numeric_limits<float>::infinity()), grow = hn::Set(d, 0x1p-18f);
  uint32_t met = 0;
  for (size_t i = 0; i < kNodeWidth; i += hn::Lanes(d)) {
    const auto origin_z = hn::Set(d, plane_.origin[2]);
    const auto near = hn::MulSub(hn::Load(d, z_near + i), sign, origin_z),
               far = hn::MulSub(hn::Load(d, z_far + i), sign, origin_z);
    auto holds = hn::And(hn::Gt(far, zero), hn::Le(near, hn::Set(d, plane_.farthest * (1 + 0x1p-20f))));
    const auto in_front = hn::Gt(near, zero);
    const auto by_near = hn::Div(one, near), by_far = hn::Div(one, far);
    auto m = hn::Max(hn::Abs(near), hn::Abs(far)), width = zero;
    const auto side = [&](size_t axis, size_t k, float first, float last, float step, float* lows, float* highs,
                          uint8_t* low_steps, uint8_t* high_steps) HWY_ATTR {
      const auto origin = hn::Set(d, plane_.origin[k]);
      const auto min = hn::Sub(hn::Load(d, node.min[axis] + i), origin),
                 max = hn::Sub(hn::Load(d, node.max[axis] + i), origin);
      // What is beside the axis is seen nearest to it at its far side.
      const auto low = hn::Sub(hn::IfThenElse(hn::Gt(min, zero), hn::Mul(min, by_far),
                                              hn::IfThenElse(in_front, hn::Mul(min, by_near), hn::Neg(infinite))),
                               grow);
      const auto high = hn::Add(hn::IfThenElse(hn::Lt(max, zero), hn::Mul(max, by_far),
                                               hn::IfThenElse(in_front, hn::Mul(max, by_near), infinite)),
                                grow);
      holds = hn::And(holds, hn::And(hn::Le(low, hn::Set(d, last)), hn::Ge(high, hn::Set(d, first))));
      m = hn::Max(m, hn::Max(hn::Abs(min), hn::Abs(max)));
      width = hn::Max(width, hn::Sub(high, low));
      hn::Store(low, d, lows + i);
      hn::Store(high, d, highs + i);
      const auto within = [&](auto at) HWY_ATTR { return hn::Min(hn::Max(at, hn::Set(d, first)), hn::Set(d, last)); };
      store_steps(within(low), first, step, low_steps + i);
      store_steps(within(high), first, step, high_steps + i);
    };
    side(x_axis, 0, plane_.u_min, plane_.u_max, plane_.u_scale, c.u_min, c.u_max, c.u_first, c.u_last);
    side(y_axis, 1, plane_.v_min, plane_.v_max, plane_.v_scale, c.v_min, c.v_max, c.v_first, c.v_last);
    store_errors(m, width, plane_, c.edge + i, c.depth + i);
    met |= lane_bits(d, holds) << i;
  }
  return met;
}

template <size_t kMost>
HWY_INLINE uint32_t FanTracer<kMost>::hold_samples(const Children& c, uint32_t met, Bits* within) const {
  const hn::CappedTag<uint8_t, 64> d;
  uint32_t held = 0;
  for (; met != 0; met &= met - 1) {
    const auto child = static_cast<size_t>(std::countr_zero(met));
    const auto u = hn::Set(d, c.u_first[child]), v = hn::Set(d, c.v_first[child]);
    const auto width = hn::Set(d, static_cast<uint8_t>(c.u_last[child] - c.u_first[child])),
               height = hn::Set(d, static_cast<uint8_t>(c.v_last[child] - c.v_first[child]));
    uint64_t any = 0;
    Bits in{};
    for (size_t w = 0; 64 * w < kMost; ++w) {
      uint64_t word = 0;
      for (size_t i = 0; i < 64; i += hn::Lanes(d)) {
        // Unsigned and modulo 256: a difference is at most the width if and only if the step lies between.
        const auto right = hn::Sub(hn::Load(d, samples_.u_step + 64 * w + i), u),
                   above = hn::Sub(hn::Load(d, samples_.v_step + 64 * w + i), v);
        const auto inside = hn::And(hn::Eq(hn::Min(right, width), right), hn::Eq(hn::Min(above, height), above));
        word |= byte_bits(d, inside) << i;
      }
      word &= live_.word(w);
      in.add_word(w, word);
      any |= word;
    }
    within[child] = in;
    held |= uint32_t{any != 0} << child;
  }
  return held;
}

template <size_t kMost>
template <uint32_t kVertices>
HWY_INLINE void FanTracer<kMost>::test(const HierarchyLeaf<kVertices>& leaf, uint32_t child, const SeenBox& box,
                                       const Bits& samples) {
  const auto decide = [&](uint32_t triangles, size_t sample) {
    return meets_some(object_.view, child, triangles, segment(sample));
  };
  if (samples.count() <= kFewOfLeaf) {
    live_ = live_.without(hit_alone(leaf, plane_, box, samples_, samples, decide));
    return;
  }
  Sides sides;
  make_sides(leaf, plane_, box, sides);
  if (sides.possible == 0) return;
  // Whichever takes fewer steps.
  constexpr int kVectors = static_cast<int>(kNodeWidth / kFloatLanes);
  const bool by_triangle =
      std::popcount(sides.possible) * std::popcount(samples.runs()) * kVectors + 4 < samples.count() * kVectors;
  const Bits hit = by_triangle ? hit_by_each(sides, box, samples_, samples, decide)
                               : each_that_is_hit(sides, box, samples_, samples, decide);
  live_ = live_.without(hit);
}

template <size_t kMost>
void FanTracer<kMost>::trace_from_each(uint32_t child, const Bits& samples) {
  for (size_t i : samples) {
    const Segment s = segment(i);
    NearRay ray;
    const Nearness nearness = make_near_ray(object_, s, ray);
    const bool met = nearness == Nearness::near ? trace_from(object_.view, child, ray, s)
                                                : nearness == Nearness::far && occluded_scalar(object_, s);
    if (met) live_ = live_.without(Bits::just(i));
  }
}

template <size_t kMost>
void FanTracer<kMost>::trace(uint32_t root) {
  struct Rest {
    const HierarchyNode* node;
    uint32_t inner;  // children with samples, a bit each, that are nodes
    Bits within[kNodeWidth];
  };
  const HierarchyView& view = object_.view;
  Rest stack[kMostLevels];
  uint32_t depth = 0;
  const auto prefetch = [&](uint32_t child) HWY_ATTR {
    for (size_t unit = 0; unit < units_of(kRootUnit); ++unit) hwy::Prefetch(view.at(child) + unit * kUnitBytes);
  };
  // Tests a node's leaves.
  const auto enter = [&](uint32_t at) HWY_ATTR {
    Rest& rest = stack[depth++];
    const HierarchyNode& node = view.node(at);
    Children children;
    rest.node = &node;
    const uint32_t met = look(node, children);
    for (uint32_t left = met; left != 0; left &= left - 1) prefetch(node.child[std::countr_zero(left)]);
    const uint32_t held = hold_samples(children, met, rest.within);
    const uint32_t leaves = held & leaves_of(node);
    rest.inner = held & ~leaves;
    for (uint32_t left = leaves; left != 0;) {
      const auto i = static_cast<size_t>(std::countr_zero(left));
      left &= left - 1;
      with_leaf(view, node.child[i],
                [&](const auto& leaf) HWY_ATTR { test(leaf, node.child[i], children.box(i), rest.within[i] & live_); });
    }
  };
  enter(root);
  while (depth > 0 && live_.any()) {
    Rest& rest = stack[depth - 1];
    if (rest.inner == 0) {
      --depth;
      continue;
    }
    const auto i = static_cast<size_t>(std::countr_zero(rest.inner));
    rest.inner &= rest.inner - 1;
    const Bits in = rest.within[i] & live_;
    if (!in.any()) continue;
    const uint32_t child = rest.node->child[i];
    if (in.count() <= kFewOfNode) trace_from_each(child, in);
    else enter(child);
  }
}

SampleBits OccludedFan(const Traced& object, const Fan& fan) noexcept {
  return fan.live.count() <= 64 ? FanTracer<64>(object, fan).blocked() : FanTracer<kFanSamples>(object, fan).blocked();
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
