#include "horizon/trace_horizon.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace vcd::baker {
namespace {

constexpr uint32_t kAllSectors = (1u << kHorizonSectors) - 1;
constexpr uint32_t kWidth = kNodeWidth;

// Things seen from above, each in a circle that is so high: boxes or triangles.
struct Circles {
  float u[kWidth], v[kWidth], radius[kWidth], high[kWidth];  // from the middle of the triangle, above its base
};

// Of half a sector and 2^-10 more, which is more than viewpoint.cpp takes: what is passed over here is not seen there.
constexpr float kTangent = 0.1999278f, kSecant = 1.01979f;

// The middles of the sectors, in floats.
constexpr auto kMiddles = [] {
  struct {
    float u[kHorizonSectors], v[kHorizonSectors];
  } middles{};
  for (size_t s = 0; s < kHorizonSectors; ++s)
    middles.u[s] = static_cast<float>(kMiddleU[s]), middles.v[s] = static_cast<float>(kMiddleV[s]);
  return middles;
}();

class HorizonTrace {
 public:
  HorizonTrace(const HierarchyView& hierarchy, const Viewpoint& from, Setters& setters)
      : hierarchy_(hierarchy), from_(from), frame_(from.frame()), setters_(setters) {
    const HierarchyHeader& h = hierarchy.header();
    // Floats err by less than 40 units of roundoff of the coordinates, in all that is compared here.
    slack_ = 0x1p-18f * greatest_coordinate(h.box_min, h.box_max);
    slopes_.fill(0);
    for (uint32_t s = 0; s < kHorizonSectors; ++s) farthest_[s] = from.farthest(s) + slack_;
  }

  Levels run() {
    const Setters before = setters_;
    setters_.fill({});
    for (uint32_t s = 0; s < kHorizonSectors; ++s)
      if (before[s].leaf != 0 && (s == 0 || before[s] != before[s - 1])) raise(before[s], kAllSectors);
    waiting_[count_++] = {kRootUnit, 0};
    while (count_ > 0 && lowest_ < kInfinity) {
      const uint32_t child = waiting_[--count_].child;
      if (child & kLeafChild) with_leaf(hierarchy_, child, [&](const auto& leaf) { visit(leaf, child); });
      else visit(hierarchy_.node(child));
    }
    return levels_;
  }

 private:
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  struct Waiting {
    uint32_t child;
    float steepness;
  };

  // The sectors in which something of the circle could be steeper than what is known.
  uint32_t sectors_of(const Circles& c, uint32_t i) const {
    const float u = c.u[i], v = c.v[i], reach = c.radius[i] + from_.radius() + slack_;
    const float clear = std::sqrt(u * u + v * v) - reach, high = c.high[i], wide = reach * kSecant;
    if (clear <= 0) return kAllSectors;
    float over[kHorizonSectors];
    for (uint32_t s = 0; s < kHorizonSectors; ++s) {
      const float f = kMiddles.u[s] * u + kMiddles.v[s] * v, side = std::fabs(kMiddles.u[s] * v - kMiddles.v[s] * u);
      const float inside = kTangent * f + wide - side;  // not negative where the circle is seen in the sector
      over[s] = std::min(inside, high - slopes_[s] * clear);
    }
    uint32_t sectors = 0;
    for (uint32_t s = 0; s < kHorizonSectors; ++s) sectors |= static_cast<uint32_t>(over[s] > 0) << s;
    return sectors;
  }

  // The sectors along whose middles a corner of a triangle (u, v, high) is steeper than what is known.
  uint32_t sectors_over(const float (&corners)[3][3]) const {
    float over[kHorizonSectors];
    for (uint32_t s = 0; s < kHorizonSectors; ++s) {
      const float slope = std::min(slopes_[s], horizon::kSteepest);
      float most = 0;
      for (const auto& [u, v, high] : corners)
        most = std::max(most, high - slope * (kMiddles.u[s] * u + kMiddles.v[s] * v - farthest_[s]));
      over[s] = slopes_[s] < kInfinity ? most : 0;
    }
    uint32_t sectors = 0;
    for (uint32_t s = 0; s < kHorizonSectors; ++s) sectors |= static_cast<uint32_t>(over[s] > 0) << s;
    return sectors;
  }

  // The boxes of which something is seen in a sector and is steeper, along its middle, than what is known of it.
  uint32_t boxes_over(const Circles& c, const float (&middle)[3][kWidth], const float (&half)[3][kWidth]) const {
    float over[kWidth] = {};
    for (uint32_t s = 0; s < kHorizonSectors; ++s) {
      const float slope = slopes_[s], cu = kMiddles.u[s], cv = kMiddles.v[s];
      if (slope == kInfinity) continue;
      float g[3], a[3];  // along n, less the slope along the sector's middle
      for (uint32_t k = 0; k < 3; ++k)
        g[k] = frame_.n[k] - slope * (cu * frame_.x[k] + cv * frame_.y[k]), a[k] = std::fabs(g[k]);
      const float more =
          slope * (cu * from_.middle_u() + cv * from_.middle_v() + farthest_[s]) - from_.base() + (1 + slope) * slack_;
      for (uint32_t i = 0; i < kWidth; ++i) {
        const float steep = g[0] * middle[0][i] + g[1] * middle[1][i] + g[2] * middle[2][i] + a[0] * half[0][i] +
                            a[1] * half[1][i] + a[2] * half[2][i] + more;
        const float wide = (c.radius[i] + from_.radius() + slack_) * kSecant;
        const float inside = kTangent * (cu * c.u[i] + cv * c.v[i]) + wide - std::fabs(cu * c.v[i] - cv * c.u[i]);
        over[i] = std::max(over[i], std::min(steep, inside));
      }
    }
    uint32_t boxes = 0;
    for (uint32_t i = 0; i < kWidth; ++i) boxes |= static_cast<uint32_t>(over[i] > 0) << i;
    return boxes;
  }

  // Those of the first `count` circles that are not below what is known of all sectors.
  uint32_t high_ones(const Circles& c, uint32_t count) const {
    float over[kWidth];
    const float reach = from_.radius() + slack_;
    for (uint32_t i = 0; i < kWidth; ++i) {
      const float clear = std::max(std::sqrt(c.u[i] * c.u[i] + c.v[i] * c.v[i]) - c.radius[i] - reach, 0.0f);
      over[i] = std::min(c.high[i], c.high[i] - lowest_ * clear);
    }
    uint32_t high = 0;
    for (uint32_t i = 0; i < kWidth; ++i) high |= static_cast<uint32_t>(over[i] > 0) << i;
    return high & ((1u << count) - 1);
  }

  void visit(const HierarchyNode& node) {
    uint32_t count = 0;
    while (count < kWidth && node.child[count] != kNoChild) ++count;
    Circles c;
    const auto &x = frame_.x, &y = frame_.y, &n = frame_.n;
    float middle[3][kWidth], half[3][kWidth];
    for (uint32_t a = 0; a < 3; ++a)
      for (uint32_t i = 0; i < kWidth; ++i) {
        const bool used = i < count;  // absent ones have infinite boxes
        const float low = used ? node.min[a][i] : frame_.corner[a], high = used ? node.max[a][i] : frame_.corner[a];
        middle[a][i] = 0.5f * low + 0.5f * high - frame_.corner[a], half[a][i] = 0.5f * high - 0.5f * low;
      }
    for (uint32_t i = 0; i < kWidth; ++i) {
      const float p = middle[0][i], q = middle[1][i], r = middle[2][i];
      const auto extent = [&](const float(&axis)[3]) {
        return std::fabs(axis[0]) * half[0][i] + std::fabs(axis[1]) * half[1][i] + std::fabs(axis[2]) * half[2][i];
      };
      const float eu = extent(x), ev = extent(y);
      c.u[i] = x[0] * p + x[1] * q + x[2] * r - from_.middle_u();
      c.v[i] = y[0] * p + y[1] * q + y[2] * r - from_.middle_v();
      c.high[i] = n[0] * p + n[1] * q + n[2] * r + extent(n) - from_.base() + slack_;
      c.radius[i] = std::sqrt(eu * eu + ev * ev);
    }
    const uint32_t first = count_;
    for (uint32_t left = high_ones(c, count) & boxes_over(c, middle, half); left; left &= left - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(left));
      const float steepness = c.high[i] / std::sqrt(c.u[i] * c.u[i] + c.v[i] * c.v[i]);
      uint32_t at = count_++;  // the steepest last: most of the others are then below what is known
      for (; at > first && waiting_[at - 1].steepness > steepness; --at) waiting_[at] = waiting_[at - 1];
      waiting_[at] = {node.child[i], steepness};
    }
  }

  template <uint32_t kVertices>
  void visit(const HierarchyLeaf<kVertices>& leaf, uint32_t child) {
    float u[kVertices], v[kVertices], w[kVertices];
    const auto &x = frame_.x, &y = frame_.y, &n = frame_.n;
    for (uint32_t i = 0; i < kVertices; ++i) {
      const float p = leaf.vertex[0][i] - frame_.corner[0], q = leaf.vertex[1][i] - frame_.corner[1],
                  r = leaf.vertex[2][i] - frame_.corner[2];
      u[i] = x[0] * p + x[1] * q + x[2] * r - from_.middle_u();
      v[i] = y[0] * p + y[1] * q + y[2] * r - from_.middle_v();
      w[i] = n[0] * p + n[1] * q + n[2] * r - from_.base() + slack_;
    }
    Circles c;
    for (uint32_t i = 0; i < kWidth; ++i) {
      const uint32_t k0 = leaf.corner[0][i], k1 = leaf.corner[1][i], k2 = leaf.corner[2][i];
      c.u[i] = (u[k0] + u[k1] + u[k2]) * (1 / 3.0f), c.v[i] = (v[k0] + v[k1] + v[k2]) * (1 / 3.0f);
      const auto away2 = [&](uint32_t k) {
        return (u[k] - c.u[i]) * (u[k] - c.u[i]) + (v[k] - c.v[i]) * (v[k] - c.v[i]);
      };
      c.radius[i] = std::sqrt(std::max({away2(k0), away2(k1), away2(k2)}));
      c.high[i] = std::max({w[k0], w[k1], w[k2]});
    }
    const auto count = static_cast<uint32_t>(std::popcount(leaf.present));
    for (uint32_t left = high_ones(c, count); left; left &= left - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(left));
      uint32_t sectors = sectors_of(c, i);
      if (sectors == 0) continue;
      const uint32_t k[] = {leaf.corner[0][i], leaf.corner[1][i], leaf.corner[2][i]};
      const float at[3][3] = {{u[k[0]], v[k[0]], w[k[0]]}, {u[k[1]], v[k[1]], w[k[1]]}, {u[k[2]], v[k[2]], w[k[2]]}};
      sectors &= sectors_over(at);
      if (sectors != 0) raise({child, i}, sectors);
    }
  }

  void raise(const InLeaf& occluder, uint32_t sectors) {
    const uint32_t raised = from_.raise(corners_at(hierarchy_, occluder), sectors, levels_);
    for (uint32_t left = raised; left; left &= left - 1) {
      const auto s = static_cast<size_t>(std::countr_zero(left));
      setters_[s] = occluder, slopes_[s] = slope_of(levels_[s]);
    }
    if (raised) lowest_ = *std::ranges::min_element(slopes_);
  }

  const HierarchyView& hierarchy_;
  const Viewpoint& from_;
  const HorizonFrame& frame_;
  Setters& setters_;
  Levels levels_{};
  std::array<float, kHorizonSectors> slopes_;  // of levels_
  std::array<float, kHorizonSectors> farthest_;
  float lowest_ = 0, slack_;  // lowest_: of slopes_
  Waiting waiting_[kMostLevels * kNodeWidth];
  uint32_t count_ = 0;
};

}  // namespace

Triangle corners_at(const HierarchyView& hierarchy, const InLeaf& at) {
  return with_leaf(hierarchy, at.leaf, [&](const auto& leaf) {
    Triangle corners;
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t a = 0; a < 3; ++a) corners[k][a] = leaf.vertex[a][leaf.corner[k][at.triangle]];
    return corners;
  });
}

Levels trace_horizon(const HierarchyView& hierarchy, const Viewpoint& from, Setters& setters) {
  return HorizonTrace(hierarchy, from, setters).run();
}

}  // namespace vcd::baker
