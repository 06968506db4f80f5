#include "segment_triangle.h"

#include <cmath>
#include <optional>

#include <boost/multiprecision/cpp_int.hpp>

namespace vcd::baker {
namespace {

namespace mp = boost::multiprecision;
using Integer = mp::number<mp::cpp_int_backend<>, mp::et_off>;

template <class Number>
using Vec = std::array<Number, 3>;

template <class Number>
Vec<Number> operator-(const Vec<Number>& a, const Vec<Number>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Vec<double> wide(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
Vec<double> wide(const Position& v) { return {v[0], v[1], v[2]}; }

// u · (v × w) in doubles, and the same sum of products with absolute values ("permanent").
struct TripleProduct {
  double value, permanent;
};

TripleProduct triple(const Vec<double>& u, const Vec<double>& v, const Vec<double>& w) {
  TripleProduct p{0, 0};
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    const double left = v[b] * w[c], right = v[c] * w[b];
    p.value += u[a] * (left - right);
    p.permanent += std::abs(u[a]) * (std::abs(left) + std::abs(right));
  }
  return p;
}

// Where u, v, w are floats or rounded differences of floats, the value's error is at most (7 + 56 e) e times the
// permanent, e = 2^-53: Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
// 1997, section 4.3 (orient3d, bound A). No product over- or underflows: of three factors from 2^-149 to 2^129.
constexpr double kSideError = 8 * 0x1p-53;
// |N - t D| for a numerator N and a denominator D = the sum of three: 8 e for N; for D 8 e and its two sums, and t's
// product, 11 e. Rounding in the permanents and their sum: below 1 e.
constexpr double kIntervalError = 16 * 0x1p-53;

int certain_sign(const TripleProduct& p) {
  const double error = kSideError * p.permanent;
  return p.value > error ? 1 : p.value < -error ? -1 : 0;
}

// Every float times 2^149 is an integer.
constexpr int kScaleBits = 149;
Integer scaled(float x) { return Integer(std::ldexp(static_cast<double>(x), kScaleBits)); }
template <class Floats>
Vec<Integer> scaled(const Floats& v) {
  return {scaled(v[0]), scaled(v[1]), scaled(v[2])};
}

Integer dot(const Vec<Integer>& a, const Vec<Integer>& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec<Integer> cross(const Vec<Integer>& a, const Vec<Integer>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct Fraction {
  Integer numerator, denominator;  // the latter positive
};
bool less(const Fraction& a, const Fraction& b) { return a.numerator * b.denominator < b.numerator * a.denominator; }
Fraction fraction(float x) { return {scaled(x), Integer(1) << kScaleBits}; }

// A line's parameters, cut down by half-spaces to the closed interval [lower, upper]; none: unbounded.
struct ClippedLine {
  Vec<Integer> origin, direction;
  std::optional<Fraction> lower, upper;

  // Keeps what is on `normal`'s side of the plane through `point`, or in it. False if nothing is left.
  bool clip(const Vec<Integer>& normal, const Vec<Integer>& point) {
    const Integer height = dot(normal, origin - point), slope = dot(normal, direction);
    if (slope > 0) {
      const Fraction t{-height, slope};
      if (!lower || less(*lower, t)) lower = t;
    } else if (slope < 0) {
      const Fraction t{height, -slope};
      if (!upper || less(t, *upper)) upper = t;
    } else {
      return height >= 0;
    }
    return !lower || !upper || !less(*upper, *lower);
  }
};

}  // namespace

WideSegment widen(const Segment& s) { return {wide(s.origin), wide(s.direction), s.t_min, s.t_max}; }

// On which sides of the three edges the line passes: Plücker coordinates, or Segura and Feito, "Algorithms to test
// ray-triangle intersection", 2001. Then, where: Möller and Trumbore 1997, without the division.
Meeting filter_meeting(const WideSegment& s, const Triangle& triangle) {
  const Vec<double> a = wide(triangle[0]), b = wide(triangle[1]), c = wide(triangle[2]);
  const Vec<double> to_a = a - s.origin, to_b = b - s.origin, to_c = c - s.origin;
  const TripleProduct sides[3] = {triple(s.direction, to_a, b - a), triple(s.direction, to_b, c - b),
                                  triple(s.direction, to_c, a - c)};
  bool left = false, right = false, doubtful = false;
  for (const TripleProduct& side : sides) {
    const int sign = certain_sign(side);
    left |= sign > 0, right |= sign < 0, doubtful |= sign == 0;
  }
  if (left && right) return Meeting::no;  // a line in the triangle's plane has no side: 0 each
  if (doubtful) return Meeting::doubtful;

  // The line meets the triangle at t = N / D, where D has the sides' sign. Made positive.
  const TripleProduct height = triple(to_a, b - a, c - a);
  const double sign = left ? 1 : -1;
  const double numerator = sign * height.value;
  const double denominator = sign * (sides[0].value + sides[1].value + sides[2].value);
  const double permanent = sides[0].permanent + sides[1].permanent + sides[2].permanent;
  // Whether t is certainly above (1) or below (-1) a bound.
  const auto compare = [&](double bound) {
    if (std::isinf(bound)) return bound > 0 ? -1 : 1;
    const double difference = numerator - bound * denominator;
    const double error = kIntervalError * (height.permanent + std::abs(bound) * permanent);
    return difference > error ? 1 : difference < -error ? -1 : 0;
  };
  const int after_begin = compare(s.t_min), after_end = compare(s.t_max);
  if (after_begin < 0 || after_end > 0) return Meeting::no;
  return after_begin > 0 && after_end < 0 ? Meeting::yes : Meeting::doubtful;
}

// The triangle is five half-spaces: both sides of its plane, and the inner side of each edge. They cut the line's
// parameters down to an interval (Cyrus and Beck 1978), with no special case for lines in the plane, through edges or
// corners, or of zero length.
bool meets_exactly(const Segment& segment, const Triangle& triangle) {
  const Vec<Integer> a = scaled(triangle[0]), b = scaled(triangle[1]), c = scaled(triangle[2]);
  const Vec<Integer> normal = cross(b - a, c - a), zero{};
  ClippedLine line{scaled(segment.origin), scaled(segment.direction), {}, {}};
  if (!line.clip(normal, a) || !line.clip(zero - normal, a) || !line.clip(cross(normal, b - a), a) ||
      !line.clip(cross(normal, c - b), b) || !line.clip(cross(normal, a - c), c))
    return false;
  const bool begins_before = std::isinf(segment.t_min) || !line.upper || less(fraction(segment.t_min), *line.upper);
  const bool ends_after = std::isinf(segment.t_max) || !line.lower || less(*line.lower, fraction(segment.t_max));
  return begins_before && ends_after;
}

}  // namespace vcd::baker
