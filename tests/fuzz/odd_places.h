// Places, segments and lights that go to the limits of floats: of every scale, flat, singular, degenerate. Drawn from
// bytes, and where these have ended from a generator whose seed they are.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include <vcd/runtime/bundle.h>
#include <vcd/runtime/scene.h>

namespace vcd::fuzz {

using Point = std::array<double, 3>;

class OddPlaces {
 public:
  explicit OddPlaces(std::span<const uint8_t> bytes) : bytes_(bytes) {
    uint64_t seed = 1;
    for (const uint8_t b : bytes) seed = seed * 0x100000001B3 + b;
    random_.seed(seed);
  }

  uint32_t below(uint32_t n) {
    if (bytes_.empty()) return static_cast<uint32_t>(random_() % n);
    const uint32_t byte = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return byte % n;
  }
  bool one_in(uint32_t n) { return below(n) == 0; }
  float uniform() { return static_cast<float>(random_() >> 40) * 0x1p-24f; }
  float between(float low, float high) { return low + (high - low) * uniform(); }

  // Of any exponent, or one of those at which something ends.
  float odd() {
    constexpr float kEnds[] = {0.0f,   -0.0f,  0x1p-149f, 0x1p-127f, 0x1p-126f, 1e-38f,  1e-37f,  3e-38f,
                               1e-30f, 1e-20f, 1e-13f,    0x1p-30f,  0x1p-40f,  0x1p40f, 0x1p60f, 1e20f,
                               1e30f,  1e37f,  1e38f,     3e38f,     0x1p100f,  1.0f};
    const float sign = one_in(2) ? -1.0f : 1.0f;
    if (one_in(2)) return sign * kEnds[below(std::size(kEnds))];
    return sign * std::ldexp(1 + uniform(), static_cast<int>(below(277)) - 149);
  }
  // Mostly 1, now and then a power of two, near or far.
  float factor() {
    if (below(3)) return 1;
    return one_in(2) ? std::exp2(between(-20, 20)) : std::exp2(static_cast<float>(static_cast<int>(below(250)) - 125));
  }
  void spoil(float& x, uint32_t one_of) {
    if (one_in(one_of)) x = one_in(12) ? not_finite() : odd();
  }

  // World = object times `scale` and more.
  Transform transform(float scale) {
    Transform t{};
    const uint32_t kind = below(12);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) t.rows[i][j] = scale * (kind < 4 ? static_cast<float>(i == j) : between(-1, 1));
      t.rows[i][3] = one_in(3) ? 0 : scale * between(-4, 4);
    }
    const auto each_row = [&](const auto& change) {
      for (auto& row : t.rows) change(row);
    };
    const uint32_t a = below(3), b = (a + 1) % 3;
    const float f = factor();
    if (kind == 1 || kind == 6) each_row([&](auto& row) { row[a] *= f; });  // a column stretched or flattened
    if (kind == 7)
      for (float& x : t.rows[a]) x *= f;
    if (kind == 8) each_row([&](auto& row) { row[a] = 0; });
    if (kind == 9) {  // singular, or nearly
      const float nearly = one_in(2) ? 0 : std::exp2(between(-24, -8));
      each_row([&](auto& row) { row[a] = row[b] + nearly * row[a]; });
    }
    if (kind == 10) each_row([&](auto& row) { row[a] += f * row[b]; });  // sheared
    if (kind == 11)
      each_row([&](auto& row) {
        for (float& x : row) spoil(x, 6);
      });
    if (kind == 3 && one_in(3)) t = {};
    if (kind == 2) each_row([&](auto& row) { row[3] *= f; });
    return t;
  }

  // Near the unit cube, or some boxes away, or on something.
  Point in_object() {
    const float spread = below(4) ? 1 : std::exp2(between(-3, 8));
    Point p;
    for (double& x : p)
      x = one_in(6) ? static_cast<double>(below(3)) / 2 : double{0.5f + spread * between(-1.5f, 1.5f)};
    return p;
  }
  static Point in_world(const Transform& t, const Point& p) {
    Point q;
    for (size_t i = 0; i < 3; ++i) {
      q[i] = double{t.rows[i][3]};
      for (size_t j = 0; j < 3; ++j) q[i] += double{t.rows[i][j]} * p[j];
    }
    return q;
  }

  Segment segment(const Transform& t) {
    const Point from = in_world(t, in_object()), to = in_world(t, in_object());
    const float f = factor();
    Segment s{{}, 0, {}, below(3) ? 1 / f : below(3) ? std::numeric_limits<float>::infinity() : odd()};
    for (size_t a = 0; a < 3; ++a) {
      s.origin[a] = static_cast<float>(from[a]);
      s.direction[a] = static_cast<float>((to[a] - double{s.origin[a]}) * double{f});
      spoil(s.origin[a], 40), spoil(s.direction[a], 20);
    }
    if (one_in(10)) s.t_min = odd();
    if (one_in(10)) s.t_min = -std::abs(s.t_max);
    return s;
  }

 private:
  float not_finite() {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const float x[] = {kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN()};
    return x[below(3)];
  }

  std::span<const uint8_t> bytes_;
  std::mt19937_64 random_;
};

// A quadrilateral and a sphere, seen from one point, and samples of both.
struct OddLights {
  std::vector<float> columns[5];
  QuadBundle quad{};
  SphereBundle sphere{};

  OddLights(OddPlaces& places, const Transform& t) {
    const Point from = places.in_world(t, places.in_object()), corner = places.in_world(t, places.in_object()),
                first = places.in_world(t, places.in_object()), second = places.in_world(t, places.in_object());
    const float f = places.factor(), g = places.one_in(2) ? f : places.factor();
    for (size_t a = 0; a < 3; ++a) {
      quad.origin[a] = static_cast<float>(from[a]);
      quad.corner[a] = static_cast<float>(corner[a]), sphere.centre[a] = quad.corner[a];
      quad.edge_u[a] = static_cast<float>((first[a] - corner[a]) * double{f});
      quad.edge_v[a] = static_cast<float>((second[a] - corner[a]) * double{g});
    }
    const uint32_t kind = places.below(10);
    const float along_u = places.between(-1, 2), along_v = places.between(-1, 2),
                thin = std::exp2(places.between(-60, -35));
    for (int a = 0; a < 3; ++a) {
      if (kind == 0) quad.edge_u[a] *= thin;
      if (kind == 1) quad.edge_u[a] = 0;                                          // a line
      if (kind == 2) quad.edge_u[a] = quad.edge_v[a] = 0;                         // a point
      if (kind == 3) quad.edge_v[a] = along_u * quad.edge_u[a];                   // parallel, within rounding
      if (kind == 4) quad.origin[a] = quad.corner[a];                             // seen from its corner
      if (kind == 5) quad.origin[a] = quad.corner[a] + along_u * quad.edge_u[a];  // from an edge
      if (kind == 6)
        quad.origin[a] = quad.corner[a] + along_u * quad.edge_u[a] + along_v * quad.edge_v[a];  // its plane
      if (kind == 7) places.spoil(quad.origin[a], 6), places.spoil(quad.corner[a], 6);
      if (kind == 7) places.spoil(quad.edge_u[a], 6), places.spoil(quad.edge_v[a], 6);
      if (kind == 8) places.spoil(sphere.centre[a], 6);
    }
    std::copy_n(quad.origin, 3, sphere.origin);
    sphere.radius = std::hypot(quad.edge_u[0], quad.edge_u[1], quad.edge_u[2]);
    if (places.one_in(3)) sphere.radius *= 0x1p-6f;
    if (places.one_in(8)) sphere.radius = 0;
    if (places.one_in(8)) sphere.radius = std::abs(places.odd());
    const size_t count = 1 + places.below(40);
    for (size_t i = 0; i < count; ++i) {
      Point out;
      double length = 0;
      for (double& x : out) x = double{places.between(-1, 1)}, length += x * x;
      for (size_t c = 0; c < 2; ++c) {
        columns[c].push_back(kind == 9 || (kind == 0 && thin < 0x1p-45f) ? static_cast<float>(places.below(2))
                                                                         : places.uniform());
        if (kind == 7) places.spoil(columns[c].back(), 30);
      }
      for (size_t a = 0; a < 3; ++a)
        columns[2 + a].push_back(
            static_cast<float>(double{sphere.centre[a]} + 0.998 * double{sphere.radius} * out[a] / std::sqrt(length)));
    }
    quad.u = columns[0], quad.v = columns[1];
    sphere.x = columns[2], sphere.y = columns[3], sphere.z = columns[4];
  }
  OddLights(const OddLights&) = delete;

  // Whether a sample is in the sphere, for certain.
  bool is_inside(size_t i) const {
    const double x = double{sphere.x[i]} - double{sphere.centre[0]}, y = double{sphere.y[i]} - double{sphere.centre[1]},
                 z = double{sphere.z[i]} - double{sphere.centre[2]};
    return x * x + y * y + z * z <= double{sphere.radius} * double{sphere.radius} * (1 - 0x1p-40);
  }
};

}  // namespace vcd::fuzz
