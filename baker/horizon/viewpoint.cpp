#include "horizon/viewpoint.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace vcd::baker {
namespace {

// The mesh may be so many times as large as the triangle: then the errors of doubles stay far below kLowestBegin.
constexpr float kMostReach = 0x1p20f;

// Of half a sector, 11.25°, and 2^-11 more: floats cannot turn the azimuth of a direction by so much.
constexpr double kSectorTangent = 0.19942002;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The differences of the corners of what is seen and of where it is seen from: their hull holds all ways from one to
// the other. A clipped triangle has at most four corners; unused places repeat the last point.
constexpr size_t kMostPoints = 12;
struct Points {
  std::array<double, kMostPoints> u, v, h;
  size_t count;
  double error;
};

// Points seen along the middle of a sector: f along it, a and b from its two sides inward.
struct InSector {
  std::array<double, kMostPoints> f, a, b;
};

// Returns the least f.
double look_along(const Points& points, uint32_t sector, InSector& at) {
  const double cu = kMiddleU[sector], cv = kMiddleV[sector];
  double least = kInfinity;
  for (size_t i = 0; i < kMostPoints; ++i) {
    const double f = cu * points.u[i] + cv * points.v[i], side = cu * points.v[i] - cv * points.u[i],
                 wide = kSectorTangent * f + 2 * points.error;
    at.f[i] = f, at.a[i] = wide - side, at.b[i] = wide + side;
    least = std::min(least, f);
  }
  return least;
}

// The steepest of some places, as a fraction.
class Steepest {
 public:
  explicit Steepest(double error) : error_(error) {}
  void add(double f, double h) {
    if (h <= 0) return;
    f -= error_;
    if (f <= 0) h = 1, f = 0;
    if (h * f_ > h_ * f) h_ = h, f_ = f;
  }
  double slope() const { return f_ > 0 ? h_ / f_ : kInfinity; }

 private:
  double error_, h_ = 0, f_ = 1;
};

// Whether all points, and so all between them, are below a slope along the middle of the sector: then all of them that
// are higher than the base lie in front, and none is steeper.
bool all_below(const Points& points, const InSector& at, double slope) {
  double over = -kInfinity;
  for (size_t i = 0; i < kMostPoints; ++i) over = std::max(over, points.h[i] - slope * (at.f[i] - points.error));
  return over <= 0;
}

// The steepest of the hull of the points, as far as it lies in the sector; 0 if none does. A fraction of two linear
// functions is greatest at a corner of what is left: at a point, or where an edge of the hull crosses a side. Edges
// lead from a point 3 i + j to one with the next i, or with the next j: one end of the difference stays a corner.
double slope_inside(const Points& points, const InSector& at) {
  Steepest steepest(points.error);
  uint32_t in_a = 0, in_b = 0;
  for (size_t i = 0; i < points.count; ++i)
    in_a |= static_cast<uint32_t>(at.a[i] >= 0) << i, in_b |= static_cast<uint32_t>(at.b[i] >= 0) << i;
  for (uint32_t left = in_a & in_b; left; left &= left - 1) {
    const auto i = static_cast<size_t>(std::countr_zero(left));
    steepest.add(at.f[i], points.h[i]);
  }
  const auto add_crossing = [&](size_t i, size_t j, const auto& side, const auto& other) {
    const double r = side[i] / (side[i] - side[j]);
    if (other[i] + r * (other[j] - other[i]) >= 0)
      steepest.add(at.f[i] + r * (at.f[j] - at.f[i]), points.h[i] + r * (points.h[j] - points.h[i]));
  };
  const auto add_crossings = [&](uint32_t in, const auto& side, const auto& other) {
    const auto n = static_cast<uint32_t>(points.count);
    const uint32_t all = (1u << n) - 1, last = 0b100100100100 & all;
    for (uint32_t left = in ^ ((in >> 3 | in << (n - 3)) & all); left; left &= left - 1) {
      const auto i = static_cast<size_t>(std::countr_zero(left));
      add_crossing(i, i + 3 < n ? i + 3 : i + 3 - n, side, other);
    }
    for (uint32_t left = in ^ ((in >> 1 & all & ~last) | (in << 2 & last)); left; left &= left - 1) {
      const auto i = static_cast<size_t>(std::countr_zero(left));
      add_crossing(i, i % 3 < 2 ? i + 1 : i - 2, side, other);
    }
  };
  add_crossings(in_a, at.a, at.b), add_crossings(in_b, at.b, at.a);
  return steepest.slope();
}

// Whether a line across one of these edges keeps all points on one side of the origin.
template <size_t kCount>
bool edges_part(const std::array<Seen, kCount>& polygon, size_t count, const Points& points) {
  for (size_t i = 0; i < count; ++i) {
    const Seen &p = polygon[i], &q = polygon[(i + 1) % count];
    const double u = q.v - p.v, v = p.u - q.u, room = 2 * points.error * (std::abs(u) + std::abs(v));
    double least = kInfinity, most = -kInfinity;
    for (size_t k = 0; k < kMostPoints; ++k) {
      const double at = u * points.u[k] + v * points.v[k];
      least = std::min(least, at), most = std::max(most, at);
    }
    if (least > room || most < -room) return true;
  }
  return false;
}

// What of a triangle is higher than `base`; returns how many corners that has.
size_t clip(const std::array<Seen, 3>& triangle, double base, std::array<Seen, 4>& above) {
  size_t count = 0;
  for (size_t i = 0; i < 3; ++i) {
    const Seen &p = triangle[i], &q = triangle[(i + 1) % 3];
    const double a = p.w - base, b = q.w - base;
    if (a >= 0) above[count++] = p;
    if ((a >= 0) == (b >= 0)) continue;
    const double r = a / (a - b);
    above[count++] = {p.u + r * (q.u - p.u), p.v + r * (q.v - p.v), base};
  }
  return count;
}

}  // namespace

Viewpoint::Viewpoint(const HorizonFrame& frame, const Triangle& corners, float reach)
    : frame_(frame), usable_(reach <= kMostReach * frame.size) {
  for (size_t i = 0; i < 3; ++i) corners_[i] = see(corners[i]);
  error_ = 0x1p-46 * reach;
  base_ = std::max({corners_[0].w, corners_[1].w, corners_[2].w}) + kLowestBegin * frame.size - error_;
  middle_u_ = static_cast<float>((corners_[0].u + corners_[1].u + corners_[2].u) / 3);
  middle_v_ = static_cast<float>((corners_[0].v + corners_[1].v + corners_[2].v) / 3);
  double radius = 0;
  for (size_t i = 0; i < 3; ++i) {
    const double u = corners_[i].u - double{middle_u_}, v = corners_[i].v - double{middle_v_};
    around_[i] = {static_cast<float>(u), static_cast<float>(v)};
    radius = std::max(radius, u * u + v * v);
  }
  radius_ = static_cast<float>(std::sqrt(radius) * (1 + 0x1p-20));
}

Seen Viewpoint::see(const std::array<float, 3>& point) const {
  const auto along = [&](const float(&axis)[3]) {
    double sum = 0;
    for (size_t a = 0; a < 3; ++a) sum += double{axis[a]} * (double{point[a]} - frame_.corner[a]);
    return sum;
  };
  return {along(frame_.x), along(frame_.y), along(frame_.n)};
}

uint32_t Viewpoint::raise(const Triangle& occluder, uint32_t which, Levels& levels) const {
  std::array<Seen, 4> above;
  const size_t corners = clip({see(occluder[0]), see(occluder[1]), see(occluder[2])}, base_, above);
  if (corners == 0) return 0;
  Points points;
  points.count = 0, points.error = error_;
  for (size_t i = 0; i < corners; ++i)
    for (const Seen& c : corners_) {
      points.u[points.count] = above[i].u - c.u, points.v[points.count] = above[i].v - c.v;
      points.h[points.count++] = above[i].w - base_ + error_;
    }
  for (size_t i = points.count; i < kMostPoints; ++i)
    points.u[i] = points.u[i - 1], points.v[i] = points.v[i - 1], points.h[i] = points.h[i - 1];

  uint32_t raised = 0;
  const auto raise_to = [&](uint32_t sector, double slope) {
    slope *= 1 + 0x1p-40;
    if (slope > double{slope_of(levels[sector])}) levels[sector] = level_above(slope), raised |= 1u << sector;
  };
  bool apart = false;
  InSector at;
  for (uint32_t left = which; left; left &= left - 1) {
    const auto s = static_cast<uint32_t>(std::countr_zero(left));
    apart |= look_along(points, s, at) > 2 * error_;
    if (levels[s] == kNever || all_below(points, at, double{slope_of(levels[s])})) continue;
    raise_to(s, slope_inside(points, at));
  }
  // Overhead: straight up, all sectors meet it.
  apart = apart || edges_part(corners_, 3, points) || edges_part(above, corners, points);
  for (uint32_t s = 0; s < kHorizonSectors && !apart; ++s) apart = look_along(points, s, at) > 2 * error_;
  for (uint32_t s = 0; s < kHorizonSectors && !apart; ++s) raise_to(s, kInfinity);
  return raised;
}

}  // namespace vcd::baker
