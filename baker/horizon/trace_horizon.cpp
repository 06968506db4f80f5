#include "horizon/trace_horizon.h"

// This file is compiled once for each kind of processor.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "horizon/trace_horizon.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd::baker {
namespace HWY_NAMESPACE {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Of half a sector and 2^-10 more, which is more than viewpoint.cpp takes: what is passed over here is not seen there.
constexpr float kTangent = 0.1999278f, kSecant = 1.01979f;

HWY_INLINE Truth positive(Floats x) { return hn::Gt(x, hn::Zero(Tag())); }
HWY_INLINE Floats sum(Floats x, Floats y, Floats z) { return hn::Add(hn::Add(x, y), z); }
HWY_INLINE Floats sum_of(const float (&a)[3], const Floats (&x)[3]) {
  return sum(hn::Mul(all(a[0]), x[0]), hn::Mul(all(a[1]), x[1]), hn::Mul(all(a[2]), x[2]));
}
HWY_INLINE Floats most_of(const Floats (&x)[3]) { return hn::Max(hn::Max(x[0], x[1]), x[2]); }
// f(s) for each bit s.
template <class F>
HWY_INLINE void for_bits(uint32_t bits, F&& f) {
  for (; bits; bits &= bits - 1) f(static_cast<uint32_t>(std::countr_zero(bits)));
}

// By sector, the children of a node or the triangles of a leaf, a bit each.
using BySector = std::array<uint32_t, kHorizonSectors>;

class HorizonTrace {
 public:
  HorizonTrace(const HierarchyView& hierarchy, const Viewpoint& from, Setters& setters)
      : hierarchy_(hierarchy), from_(from), frame_(from.frame()), setters_(setters) {
    const HierarchyHeader& h = hierarchy.header();
    // Floats err by less than 40 units of roundoff of the coordinates, in all that is compared here.
    slack_ = 0x1p-18f * greatest_coordinate(h.box_min, h.box_max);
    for (uint32_t s = 0; s < kHorizonSectors; ++s) {
      Sector& sector = sectors_[s];
      sector.u = static_cast<float>(kMiddleU[s]), sector.v = static_cast<float>(kMiddleV[s]);
      for (const auto& [u, v] : from.around()) {
        const float f = sector.u * u + sector.v * v, side = sector.u * v - sector.v * u;
        sector.farthest = std::max(sector.farthest, f);
        sector.left = std::max(sector.left, side - kTangent * f);
        sector.right = std::max(sector.right, -side - kTangent * f);
        sector.behind = std::max(sector.behind, -f);
      }
      sector.farthest += slack_, sector.left += 2 * slack_, sector.right += 2 * slack_, sector.behind += slack_;
      set_slope(s, 0);
    }
  }

  Levels run() {
    const Setters before = setters_;
    setters_.fill({});
    for (uint32_t s = 0; s < kHorizonSectors;) {
      const InLeaf& setter = before[s];
      uint32_t in = 0;
      for (; s < kHorizonSectors && before[s] == setter; ++s) in |= 1u << s;
      if (setter.leaf != 0) raise(setter, (in | in << 1 | in >> 1) & kAllSectors);
    }
    waiting_[count_++] = {kRootUnit, 0, kAllSectors};
    while (count_ > 0 && open_ != 0) {
      const Waiting next = waiting_[--count_];
      if (next.child & kLeafChild)
        with_leaf(hierarchy_, next.child, [&](const auto& leaf) { visit(leaf, next.child, next.sectors); });
      else visit(hierarchy_.node(next.child), next.sectors);
    }
    return levels_;
  }

 private:
  static constexpr uint32_t kAllSectors = (1u << kHorizonSectors) - 1;
  struct Waiting {
    uint32_t child;
    float steepness;
    uint32_t sectors;  // in which it may be steeper than what is known
  };

  // Of the triangle: how far it reaches along the middle of a sector, and out of its two sides. Of what is seen: that
  // which is above a plane, 0 where a segment could be as steep as the slope.
  struct Sector {
    float u, v;  // the middle
    float farthest = 0, left = 0, right = 0, behind = 0;
    float slope;
    float up[3], size[3], more;  // gradient of the height above that plane; its absolute value; the height of corner 0
  };

  void set_slope(uint32_t s, float slope) {
    Sector& sector = sectors_[s];
    sector.slope = slope;
    if (slope == kInfinity) {
      open_ &= ~(1u << s);
      return;
    }
    for (uint32_t a = 0; a < 3; ++a) {
      sector.up[a] = frame_.n[a] - slope * (sector.u * frame_.x[a] + sector.v * frame_.y[a]);
      sector.size[a] = std::fabs(sector.up[a]);
    }
    sector.more = slope * (sector.u * from_.middle_u() + sector.v * from_.middle_v() + sector.farthest) - from_.base() +
                  (1 + slope) * slack_;
  }

  void visit(const HierarchyNode& node, uint32_t sectors) {
    BySector over{};
    uint32_t seen = 0;
    HWY_ALIGN float steepness[kNodeWidth];
    const float reach = from_.radius() + slack_;
    for (size_t i = 0; i < kNodeWidth; i += kStep) {  // of absent children all is NaN, and no comparison true
      Floats middle[3], half[3];
      for (uint32_t a = 0; a < 3; ++a) {
        const Floats low = hn::Mul(all(0.5f), load(node.min[a] + i)), high = hn::Mul(all(0.5f), load(node.max[a] + i));
        middle[a] = hn::Sub(hn::Add(low, high), all(frame_.corner[a])), half[a] = hn::Sub(high, low);
      }
      const auto extent = [&](const float(&axis)[3]) HWY_ATTR {
        const float size[3] = {std::fabs(axis[0]), std::fabs(axis[1]), std::fabs(axis[2])};
        return sum_of(size, half);
      };
      const Floats u = hn::Sub(sum_of(frame_.x, middle), all(from_.middle_u())),
                   v = hn::Sub(sum_of(frame_.y, middle), all(from_.middle_v())),
                   high = hn::Add(hn::Add(sum_of(frame_.n, middle), extent(frame_.n)), all(slack_ - from_.base()));
      const Floats eu = extent(frame_.x), ev = extent(frame_.y);
      const Floats radius = hn::Add(hn::Sqrt(hn::Add(hn::Mul(eu, eu), hn::Mul(ev, ev))), all(reach)),
                   away = hn::Sqrt(hn::Add(hn::Mul(u, u), hn::Mul(v, v)));
      const Truth above = positive(high);
      if (hn::AllFalse(Tag(), above)) continue;
      hn::Store(hn::Div(high, away), Tag(), steepness + i);
      const Floats wide = hn::Mul(radius, all(kSecant));
      for_bits(sectors & open_, [&](uint32_t s) HWY_ATTR {
        const Sector& sector = sectors_[s];
        const Floats steep = hn::Add(hn::Add(sum_of(sector.up, middle), sum_of(sector.size, half)), all(sector.more));
        const Floats f = hn::Add(hn::Mul(all(sector.u), u), hn::Mul(all(sector.v), v)),
                     side = hn::Sub(hn::Mul(all(sector.u), v), hn::Mul(all(sector.v), u));
        const Floats inside = hn::Sub(hn::Add(hn::Mul(all(kTangent), f), wide), hn::Abs(side));
        const uint32_t bits = bits_of(hn::And(above, positive(hn::Min(steep, inside)))) << i;
        over[s] |= bits, seen |= bits;
      });
    }
    const uint32_t first = count_;
    for_bits(seen, [&](uint32_t i) {
      uint32_t in = 0;
      for (uint32_t s = 0; s < kHorizonSectors; ++s) in |= (over[s] >> i & 1) << s;
      uint32_t at = count_++;  // the steepest last: most of the others are then below what is known
      for (; at > first && waiting_[at - 1].steepness > steepness[i]; --at) waiting_[at] = waiting_[at - 1];
      waiting_[at] = {node.child[i], steepness[i], in};
    });
  }

  // The corners of triangles seen from above, from the middle of the triangle and above its base; and which are so near
  // that may_raise() cannot tell whether they are overhead.
  struct Corners {
    Floats u[3], v[3], high[3];
    Truth near;
  };

  template <uint32_t kVertices>
  void visit(const HierarchyLeaf<kVertices>& leaf, uint32_t child, uint32_t sectors) {
    HWY_ALIGN float u[kVertices], v[kVertices], high[kVertices];
    for (size_t i = 0; i < kVertices; i += kStep) {
      Floats at[3];
      for (uint32_t a = 0; a < 3; ++a) at[a] = hn::Sub(load(leaf.vertex[a] + i), all(frame_.corner[a]));
      hn::Store(hn::Sub(sum_of(frame_.x, at), all(from_.middle_u())), Tag(), u + i);
      hn::Store(hn::Sub(sum_of(frame_.y, at), all(from_.middle_v())), Tag(), v + i);
      hn::Store(hn::Add(sum_of(frame_.n, at), all(slack_ - from_.base())), Tag(), high + i);
    }
    Corners corners[kNodeWidth / kStep];
    for (size_t i = 0; i < kNodeWidth; i += kStep) {
      Corners& c = corners[i / kStep];
      for (uint32_t k = 0; k < 3; ++k) {
        const hn::Rebind<uint8_t, Tag> bytes;
        const auto index = hn::PromoteTo(hn::RebindToSigned<Tag>(), hn::LoadU(bytes, leaf.corner[k] + i));
        c.u[k] = hn::GatherIndex(Tag(), u, index), c.v[k] = hn::GatherIndex(Tag(), v, index);
        c.high[k] = hn::GatherIndex(Tag(), high, index);
      }
      const Floats third = all(1 / 3.0f), u0 = hn::Mul(third, sum(c.u[0], c.u[1], c.u[2])),
                   v0 = hn::Mul(third, sum(c.v[0], c.v[1], c.v[2]));
      const auto length = [](Floats x, Floats y) HWY_ATTR { return hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y))); };
      Floats away[3];
      for (uint32_t k = 0; k < 3; ++k) away[k] = length(hn::Sub(c.u[k], u0), hn::Sub(c.v[k], v0));
      c.near = hn::Lt(hn::Sub(length(u0, v0), most_of(away)), all(2 * from_.radius() + 4 * slack_));
    }
    BySector over{};
    uint32_t seen = 0;
    const auto look = [&](uint32_t some) HWY_ATTR {
      for_bits(some, [&](uint32_t s) HWY_ATTR {
        over[s] = 0;
        for (size_t i = 0; i < kNodeWidth; i += kStep) over[s] |= bits_of(may_raise(corners[i / kStep], s)) << i;
        over[s] &= leaf.present;
      });
    };
    look(sectors &= open_);
    for_bits(sectors, [&](uint32_t s) { seen |= over[s]; });
    for_bits(seen, [&](uint32_t i) HWY_ATTR {
      uint32_t in = 0;
      for_bits(sectors & open_, [&](uint32_t s) { in |= (over[s] >> i & 1) << s; });
      if (in != 0) look(raise({child, i}, in) & sectors & open_);
    });
  }

  // Whether parts of triangles are in a sector, seen from anywhere on the triangle, and steeper than what is known:
  // what of them is in front of it, and not beyond either side of the sector. The height above the plane of the slope
  // is greatest at a corner of that part: at a corner of the triangle, or where one of its edges leaves it. Nothing
  // else is a corner of parts that are not near.
  HWY_INLINE Truth may_raise(const Corners& c, uint32_t s) const {
    const Sector& sector = sectors_[s];
    Floats steep[3], in[3][3];
    for (uint32_t k = 0; k < 3; ++k) {
      const Floats f = hn::Add(hn::Mul(all(sector.u), c.u[k]), hn::Mul(all(sector.v), c.v[k])),
                   side = hn::Sub(hn::Mul(all(sector.u), c.v[k]), hn::Mul(all(sector.v), c.u[k])),
                   wide = hn::Mul(all(kTangent), f);
      steep[k] = hn::Add(hn::Sub(c.high[k], hn::Mul(all(sector.slope), f)), all(sector.slope * sector.farthest));
      in[0][k] = hn::Add(hn::Sub(wide, side), all(sector.left));
      in[1][k] = hn::Add(hn::Add(wide, side), all(sector.right));
      in[2][k] = hn::Add(f, all(sector.behind));
    }
    Truth some = positive(hn::Min(most_of(steep), most_of(c.high)));
    for (const auto& inside : in) some = hn::And(some, positive(most_of(inside)));
    if (hn::AllFalse(Tag(), some)) return some;
    Truth found = c.near;
    for (uint32_t k = 0; k < 3; ++k)
      found = hn::Or(found, positive(hn::Min(hn::Min(steep[k], in[0][k]), hn::Min(in[1][k], in[2][k]))));
    for (uint32_t line = 0; line < 3; ++line)
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t next = (k + 1) % 3;
        const Floats p = in[line][k], q = in[line][next], sign = hn::And(p, hn::SignBit(Tag()));
        const auto where = [&](const Floats(&x)[3])
                               HWY_ATTR { return hn::Xor(hn::Sub(hn::Mul(p, x[next]), hn::Mul(q, x[k])), sign); };
        const Floats least = hn::Min(hn::Min(where(steep), where(in[(line + 1) % 3])), where(in[(line + 2) % 3]));
        found = hn::Or(found, hn::And(hn::Lt(hn::Mul(p, q), hn::Zero(Tag())), positive(least)));
      }
    return hn::And(some, found);
  }

  uint32_t raise(const InLeaf& occluder, uint32_t sectors) {
    const uint32_t raised = from_.raise(corners_at(hierarchy_, occluder), sectors, levels_);
    for_bits(raised, [&](uint32_t s) { setters_[s] = occluder, set_slope(s, slope_of(levels_[s])); });
    return raised;
  }

  const HierarchyView& hierarchy_;
  const Viewpoint& from_;
  const HorizonFrame& frame_;
  Setters& setters_;
  Levels levels_{};
  std::array<Sector, kHorizonSectors> sectors_;
  uint32_t open_ = kAllSectors;  // those with a slope
  float slack_;
  Waiting waiting_[kMostLevels * kNodeWidth];
  uint32_t count_ = 0;
};

}  // namespace

Levels TraceHorizon(const HierarchyView& hierarchy, const Viewpoint& from, Setters& setters) {
  return HorizonTrace(hierarchy, from, setters).run();
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd::baker
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vcd::baker {

HWY_EXPORT(TraceHorizon);

Triangle corners_at(const HierarchyView& hierarchy, const InLeaf& at) {
  return with_leaf(hierarchy, at.leaf, [&](const auto& leaf) {
    Triangle corners;
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t a = 0; a < 3; ++a) corners[k][a] = leaf.vertex[a][leaf.corner[k][at.triangle]];
    return corners;
  });
}

Levels trace_horizon(const HierarchyView& hierarchy, const Viewpoint& from, Setters& setters) {
  return HWY_DYNAMIC_DISPATCH(TraceHorizon)(hierarchy, from, setters);
}

}  // namespace vcd::baker
#endif
