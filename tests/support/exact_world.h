// Whether a segment meets a mesh that a transform has placed in the world: exactly, for any floats, by the transform's
// own numbers, not by vertices that were rounded.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>

#include <vcd/baker/mesh.h>
#include <vcd/format/segment.h>
#include <vcd/runtime/scene.h>

#include "support/segments.h"

namespace vcd::test {

constexpr Transform kStill = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

namespace mp = boost::multiprecision;
using Integer = mp::number<mp::cpp_int_backend<>, mp::et_off>;
using IntegerVec = std::array<Integer, 3>;

// The exponent of a finite float's lowest bit that is set; of 0 a large one.
inline int lowest_bit(float x) {
  if (x == 0) return 1000;
  int exponent;
  auto mantissa = static_cast<long>(std::ldexp(std::frexp(std::abs(x), &exponent), 24));
  for (exponent -= 24; mantissa % 2 == 0; mantissa /= 2) ++exponent;
  return exponent;
}
// x / 2^unit, which is an integer.
inline Integer in_units(float x, int unit) {
  if (x == 0) return 0;
  const int low = lowest_bit(x);
  return Integer(static_cast<long>(std::ldexp(static_cast<double>(x), -low))) << (low - unit);
}

inline IntegerVec operator-(const IntegerVec& a, const IntegerVec& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Integer dot(const IntegerVec& a, const IntegerVec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline IntegerVec cross(const IntegerVec& a, const IntegerVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Part of a line, cut down by half-spaces (Cyrus and Beck 1978). Positions are in units of 2^position, directions in
// units of 2^direction.
class ExactSegment {
 public:
  ExactSegment(const Segment& s, int position, int direction) : segment_(s), shift_(direction - position) {
    for (size_t a = 0; a < 3; ++a)
      origin_[a] = in_units(s.origin[a], position), direction_[a] = in_units(s.direction[a], direction);
  }

  // A triangle without an area is not met. Triangles are closed, the segment is open.
  bool meets(const IntegerVec& a, const IntegerVec& b, const IntegerVec& c) const {
    const IntegerVec normal = cross(b - a, c - a), zero{};
    if (normal == zero) return false;
    Interval t;
    if (!clip(t, normal, a) || !clip(t, zero - normal, a)) return false;
    if (!clip(t, cross(normal, b - a), a) || !clip(t, cross(normal, c - b), b) || !clip(t, cross(normal, a - c), c))
      return false;
    return (!t.lower || below(*t.lower, segment_.t_max)) && (!t.upper || above(*t.upper, segment_.t_min));
  }

 private:
  struct Fraction {
    Integer numerator, denominator;  // the latter positive
  };
  struct Interval {
    std::optional<Fraction> lower, upper;
  };
  static bool less(const Fraction& a, const Fraction& b) {
    return a.numerator * b.denominator < b.numerator * a.denominator;
  }
  bool clip(Interval& t, const IntegerVec& normal, const IntegerVec& point) const {
    const Integer height = dot(normal, origin_ - point), slope = dot(normal, direction_);
    if (slope == 0) return height >= 0;
    const Fraction at = slope > 0 ? Fraction{-height, slope} : Fraction{height, -slope};
    if (slope > 0 && (!t.lower || less(*t.lower, at))) t.lower = at;
    if (slope < 0 && (!t.upper || less(at, *t.upper))) t.upper = at;
    return !t.lower || !t.upper || !less(*t.upper, *t.lower);
  }
  // A parameter of the line in these units is t · 2^shift_.
  Fraction in_line(float t) const {
    const int low = t == 0 ? 0 : lowest_bit(t), exponent = low + shift_;
    const Integer mantissa = t == 0 ? Integer(0) : in_units(t, low);
    return exponent >= 0 ? Fraction{mantissa << exponent, 1} : Fraction{mantissa, Integer(1) << -exponent};
  }
  bool below(const Fraction& x, float t) const { return std::isinf(t) ? t > 0 : less(x, in_line(t)); }
  bool above(const Fraction& x, float t) const { return std::isinf(t) ? t < 0 : less(in_line(t), x); }

  Segment segment_;
  int shift_;
  IntegerVec origin_, direction_;
};

class ExactInstance {
 public:
  // The transform is finite.
  ExactInstance(const baker::SourceMesh& mesh, const Transform& to_world) : triangles_(mesh.triangles) {
    unit_ = 1000;
    for (const auto& row : to_world.rows) unit_ = std::min(unit_, lowest_bit(row[3]));
    for (const auto& p : mesh.positions)
      for (const auto& row : to_world.rows)
        for (size_t j = 0; j < 3; ++j) unit_ = std::min(unit_, lowest_bit(row[j]) + lowest_bit(p[j]));
    for (const auto& p : mesh.positions) {
      IntegerVec& vertex = vertices_.emplace_back();
      for (size_t i = 0; i < 3; ++i) {
        const auto& row = to_world.rows[i];
        vertex[i] = in_units(row[3], unit_);
        for (size_t j = 0; j < 3; ++j)
          if (row[j] != 0 && p[j] != 0) {
            const int low = lowest_bit(p[j]);
            vertex[i] += in_units(row[j], unit_ - low) * in_units(p[j], low);
          }
        const double x = std::ldexp(vertex[i].convert_to<double>(), unit_);
        low_[i] = std::min(low_[i], x), high_[i] = std::max(high_[i], x);
      }
    }
  }

  bool meets(const Segment& s) const {
    if (!is_finite(s) || !(s.t_min < s.t_max) || is_beside(s)) return false;
    int position = unit_, direction = 1000;
    for (size_t a = 0; a < 3; ++a)
      position = std::min(position, lowest_bit(s.origin[a])),
      direction = std::min(direction, lowest_bit(s.direction[a]));
    if (direction == 1000) direction = 0;
    const ExactSegment exact(s, position, direction);
    std::vector<IntegerVec> at = vertices_;
    for (IntegerVec& v : at)
      for (Integer& x : v) x <<= unit_ - position;
    return std::any_of(triangles_.begin(), triangles_.end(),
                       [&](const auto& t) { return exact.meets(at[t[0]], at[t[1]], at[t[2]]); });
  }

 private:
  // For certain: in doubles, where quotients of floats are far from all limits. False is no answer.
  bool is_beside(const Segment& s) const {
    constexpr double kSlack = 0x1p-40;
    double near = s.t_min, far = s.t_max;
    for (size_t a = 0; a < 3; ++a) {
      const double o = s.origin[a], d = s.direction[a];
      const double low = low_[a] - o - kSlack * (std::abs(low_[a]) + std::abs(o)),
                   high = high_[a] - o + kSlack * (std::abs(high_[a]) + std::abs(o));
      if (d == 0 && (low > 0 || high < 0)) return true;
      if (d == 0) continue;
      near = std::max(near, std::min(low / d, high / d)), far = std::min(far, std::max(low / d, high / d));
    }
    return near - kSlack * std::abs(near) > far + kSlack * std::abs(far);
  }

  std::vector<baker::TriangleIndices> triangles_;
  std::array<double, 3> low_ = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high_ = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  std::vector<IntegerVec> vertices_;
  int unit_;  // vertices are in units of 2^unit_
};

}  // namespace vcd::test
