// Three floats, and how they stand in space.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace vcd::render {

struct Vec3 {
  float x = 0, y = 0, z = 0;
};
inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(Vec3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
inline Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
// In double, which holds the squares of all floats.
inline double wide_length(Vec3 a) { return std::sqrt(double{a.x} * a.x + double{a.y} * a.y + double{a.z} * a.z); }
inline float length(Vec3 a) { return static_cast<float>(wide_length(a)); }
inline Vec3 unit(Vec3 a) {
  const double scale = 1 / wide_length(a);
  return {static_cast<float>(a.x * scale), static_cast<float>(a.y * scale), static_cast<float>(a.z * scale)};
}
inline Vec3 vec3(const std::array<float, 3>& a) { return {a[0], a[1], a[2]}; }

// x → matrix · x + offset.
struct Affine {
  Vec3 column[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Vec3 offset;

  Vec3 vector(Vec3 v) const { return column[0] * v.x + column[1] * v.y + column[2] * v.z; }
  Vec3 point(Vec3 p) const { return vector(p) + offset; }
  // The normal of a surface, given that *this is the inverse of the map that moved the surface. Not unit length.
  Vec3 transposed(Vec3 n) const { return {dot(column[0], n), dot(column[1], n), dot(column[2], n)}; }
};

// From the row-major 3 × 4 matrix of a scene file, and back the other way. The determinant must not be zero.
Affine affine(const std::array<float, 12>& rows);
Affine inverse(const Affine& a);

struct Box {
  Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};

  void add(Vec3 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void add(const Box& b) { add(b.low), add(b.high); }
  Vec3 center() const { return (low + high) * 0.5f; }
  float diagonal() const { return length(high - low); }
  float farthest() const {  // from the origin, along an axis
    return std::fmax(std::fmax(std::fmax(-low.x, -low.y), -low.z), std::fmax(std::fmax(high.x, high.y), high.z));
  }
};

// From a float of this size to the next.
inline float step_at(float size) { return size > 0 ? std::ldexp(1.0f, std::ilogb(size) - 23) : 0; }

// The axis-aligned box of a box's image.
Box transformed(const Affine& a, const Box& box);

}  // namespace vcd::render
