#include <vcd/format/meets.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>

#include "integer.h"

namespace vcd {
namespace {

template <class Number>
using Vec = std::array<Number, 3>;

template <class Number>
Vec<Number> operator-(const Vec<Number>& a, const Vec<Number>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// ---- The filter

enum class Meeting { no, yes, doubtful };

// u · (v × w) in doubles, and the same sum of products with absolute values ("permanent").
struct TripleProduct {
  double value, permanent;
};

TripleProduct triple(const Vec<double>& u, const Vec<double>& v, const Vec<double>& w) {
  TripleProduct p{0, 0};
  for (size_t a = 0; a < 3; ++a) {
    const size_t b = (a + 1) % 3, c = (a + 2) % 3;
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

Vec<double> wide(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
Vec<double> wide(const Vec<float>& v) { return {v[0], v[1], v[2]}; }

// On which sides of the three edges the line passes: Plücker coordinates, or Segura and Feito, "Algorithms to test
// ray-triangle intersection", 2001. Then, where: Möller and Trumbore 1997, without the division.
Meeting filter(const Segment& s, const Triangle& corners) {
  const Vec<double> a = wide(corners[0]), b = wide(corners[1]), c = wide(corners[2]), origin = wide(s.origin),
                    direction = wide(s.direction);
  const Vec<double> to_a = a - origin, to_b = b - origin, to_c = c - origin;
  const TripleProduct sides[3] = {triple(direction, to_a, b - a), triple(direction, to_b, c - b),
                                  triple(direction, to_c, a - c)};
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

// ---- The exact answer

// x = mantissa · 2^exponent. Read from its bits, whatever the processor makes of subnormal numbers.
struct Dyadic {
  uint32_t mantissa;
  int exponent;
  bool negative;
};
Dyadic dyadic(float x) {
  const auto bits = std::bit_cast<uint32_t>(x);
  const uint32_t fraction = bits & 0x7FFFFF;
  const int exponent = static_cast<int>(bits >> 23 & 255);
  return {exponent == 0 ? fraction : fraction | 0x800000, std::max(exponent, 1) - 150, bits >> 31 != 0};
}
bool is_subnormal(float x) { return (std::bit_cast<uint32_t>(x) << 1) - 1 < 0x00FFFFFF; }

// x · 2^-exponent, an integer.
Integer scaled(float x, int exponent) {
  const Dyadic d = dyadic(x);
  return d.mantissa == 0 ? Integer() : Integer(d.mantissa, static_cast<unsigned>(d.exponent - exponent), d.negative);
}
template <class Floats>
Vec<Integer> scaled(const Floats& v, int exponent) {
  return {scaled(v[0], exponent), scaled(v[1], exponent), scaled(v[2], exponent)};
}

Integer dot(const Vec<Integer>& a, const Vec<Integer>& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec<Integer> cross(const Vec<Integer>& a, const Vec<Integer>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct Fraction {
  Integer numerator, denominator;  // the latter positive
};
bool less(const Fraction& a, const Fraction& b) { return a.numerator * b.denominator < b.numerator * a.denominator; }
Fraction fraction(float x) {
  const Dyadic d = dyadic(x);
  return {Integer(d.mantissa, static_cast<unsigned>(std::max(d.exponent, 0)), d.negative),
          Integer(1, static_cast<unsigned>(std::max(-d.exponent, 0)), false)};
}

// A line's parameters, cut down by half-spaces to the closed interval [lower, upper]; none: unbounded.
struct ClippedLine {
  Vec<Integer> origin, direction;
  std::optional<Fraction> lower{}, upper{};

  // Keeps what is on `normal`'s side of the plane through `point`, or in it. False if nothing is left.
  bool clip(const Vec<Integer>& normal, const Vec<Integer>& point) {
    const Integer height = dot(normal, origin - point), slope = dot(normal, direction);
    if (slope.sign() > 0) {
      const Fraction t{-height, slope};
      if (!lower || less(*lower, t)) lower = t;
    } else if (slope.sign() < 0) {
      const Fraction t{height, -slope};
      if (!upper || less(t, *upper)) upper = t;
    } else {
      return height.sign() >= 0;
    }
    return !lower || !upper || !less(*upper, *lower);
  }
};

// The triangle is five half-spaces: both sides of its plane, and the inner side of each edge. They cut the line's
// parameters down to an interval (Cyrus and Beck 1978), with no special case for lines in the plane, through edges or
// corners, or of zero length.
//
// Integers have at most 2240 bits: coordinates and directions, in units of the least exponent, are below 2^277; a
// normal is below 2^557, an edge's 2^836, heights and slopes 2^1117, and fractions are compared by products of two of
// those.
bool meets_exactly(const Segment& s, const Triangle& corners) {
  int least = 0;
  const auto lower_to = [&least](float x) {
    if (x != 0 || is_subnormal(x)) least = std::min(least, dyadic(x).exponent);
  };
  for (const Vec<float>& corner : corners) std::for_each(corner.begin(), corner.end(), lower_to);
  std::for_each(std::begin(s.origin), std::end(s.origin), lower_to);
  std::for_each(std::begin(s.direction), std::end(s.direction), lower_to);
  const Vec<Integer> a = scaled(corners[0], least), b = scaled(corners[1], least), c = scaled(corners[2], least);
  const Vec<Integer> normal = cross(b - a, c - a), zero{};
  ClippedLine line{scaled(s.origin, least), scaled(s.direction, least)};
  if (!line.clip(normal, a) || !line.clip(zero - normal, a) || !line.clip(cross(normal, b - a), a) ||
      !line.clip(cross(normal, c - b), b) || !line.clip(cross(normal, a - c), c))
    return false;
  const bool begins_before = std::isinf(s.t_min) || !line.upper || less(fraction(s.t_min), *line.upper);
  const bool ends_after = std::isinf(s.t_max) || !line.lower || less(*line.lower, fraction(s.t_max));
  return begins_before && ends_after;
}

}  // namespace

bool can_meet(const Segment& s) noexcept {
  const auto finite = [](const float(&v)[3]) {
    return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
  };
  return s.t_min < s.t_max && finite(s.origin) && finite(s.direction);
}

bool meets(const Segment& s, const Triangle& triangle) noexcept {
  if (!can_meet(s)) return false;
  // A processor that takes subnormal numbers for zero would mislead the filter.
  bool subnormal = is_subnormal(s.t_min) || is_subnormal(s.t_max);
  for (size_t i = 0; i < 3; ++i) {
    subnormal |= is_subnormal(s.origin[i]) || is_subnormal(s.direction[i]);
    for (const Vec<float>& corner : triangle) subnormal |= is_subnormal(corner[i]);
  }
  if (!subnormal) {
    const Meeting meeting = filter(s, triangle);
    if (meeting != Meeting::doubtful) return meeting == Meeting::yes;
  }
  return meets_exactly(s, triangle);
}

}  // namespace vcd
