// Three doubles, and what growing things needs of them. Only + - * / and sqrt, which IEEE 754 rounds alike everywhere:
// no sine of the C library, whose last bit differs between machines.
#pragma once

#include <cmath>
#include <cstdint>

#include <vcd/scenes/scene.h>

#include "random.h"

namespace vcd::scenes {

inline constexpr double kPi = 3.14159265358979323846;

struct Double3 {
  double x = 0, y = 0, z = 0;
};

inline Double3 operator+(Double3 a, Double3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Double3 operator-(Double3 a, Double3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Double3 operator*(double s, Double3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Double3 a, Double3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(Double3 a) { return std::sqrt(dot(a, a)); }
inline Double3 unit(Double3 a) { return (1 / length(a)) * a; }
inline Double3 mix(Double3 a, Double3 b, double t) { return (1 - t) * a + t * b; }
inline Double3 cross(Double3 a, Double3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline constexpr Double3 kUp = {0, 1, 0};

struct CosSin {
  double cos, sin;
};

// Cosine and sine of an angle in whole turns: Taylor series on an eighth of a turn to either side, good to 1e-15.
inline CosSin at_turn(double turns) {
  const double quarter = std::floor(4 * turns + 0.5);
  const double x = 2 * kPi * (turns - 0.25 * quarter), xx = x * x;
  double sine = 1, cosine = 1;
  for (int k = 16; k >= 2; k -= 2) {
    sine = 1 - sine * xx / (k * (k + 1));
    cosine = 1 - cosine * xx / (k * (k - 1));
  }
  sine *= x;
  switch (static_cast<int64_t>(quarter) & 3) {
    case 0: return {cosine, sine};
    case 1: return {-sine, cosine};
    case 2: return {-cosine, -sine};
    default: return {sine, -cosine};
  }
}

// Two unit vectors across a unit axis: side × forth = axis.
struct Across {
  Double3 side, forth;
};
inline Across across(Double3 axis) {
  const Double3 other = std::fabs(axis.y) > 0.9 ? Double3{1, 0, 0} : kUp;
  const Double3 side = unit(cross(other, axis));
  return {side, cross(axis, side)};
}

// A unit vector that stands at `lean` turns from the axis, `turn` turns about it.
inline Double3 leaning(Double3 axis, double lean, double turn) {
  const auto [side, forth] = across(axis);
  const CosSin l = at_turn(lean), t = at_turn(turn);
  return l.cos * axis + l.sin * (t.cos * side + t.sin * forth);
}

inline Double3 random_direction(Random& random) {
  const double y = random.uniform(-1, 1), r = std::sqrt(1 - y * y);
  const CosSin t = at_turn(random.uniform());
  return {r * t.cos, y, r * t.sin};
}

// Rounds to 1/65536, so that nothing of the arithmetic's last bits can show in a mesh. Never -0.
inline Vec3 on_grid(Double3 p) {
  const auto round = [](double x) { return static_cast<float>(std::floor(x * 65536 + 0.5) / 65536); };
  return {round(p.x), round(p.y), round(p.z)};
}

inline Vec3 to_float(Double3 p) { return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}; }
inline Double3 to_double(const Vec3& p) { return {p[0], p[1], p[2]}; }

}  // namespace vcd::scenes
