// Fuzz bytes as floats of any bit pattern, and the queries that are made of them.
#pragma once

#include <cmath>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include <vcd/format/layout.h>
#include <vcd/runtime/bundle.h>
#include <vcd/runtime/scene.h>

namespace vcd::fuzz {

// Takes floats from bytes, and where these have ended from a generator whose seed they are: places about the box [0,
// 1]^3, and now and then a float of any exponent.
class HostileFloats {
 public:
  explicit HostileFloats(std::span<const uint8_t> bytes) : bytes_(bytes) {
    for (const uint8_t b : bytes) seed_ = seed_ * 31 + b;
    random_.seed(seed_);
  }
  float next() {
    float x;
    if (bytes_.size() < sizeof x) return below(40) ? -1 + 3 * uniform() : odd();
    std::memcpy(&x, bytes_.data(), sizeof x);
    bytes_ = bytes_.subspan(sizeof x);
    return x;
  }
  void next(float (&three)[3]) {
    for (float& x : three) x = next();
  }
  uint32_t below(uint32_t n) { return static_cast<uint32_t>(random_() % n); }
  bool at_end() const { return bytes_.size() < sizeof(float); }
  // Of any exponent, subnormal ones too.
  float odd() { return std::ldexp(1 + uniform(), static_cast<int>(below(277)) - 149) * (below(2) ? -1.0f : 1.0f); }

 private:
  float uniform() { return static_cast<float>(random_() >> 8) * 0x1p-24f; }

  std::span<const uint8_t> bytes_;
  uint32_t seed_ = 1;
  std::mt19937 random_;
};

// From the unit cube to the box, so that what a generator makes is about it.
inline void stretch(float (&point)[3], const ObjectRecord& record, bool direction = false) {
  for (int a = 0; a < 3; ++a)
    point[a] = point[a] * (record.box_max[a] - record.box_min[a]) + (direction ? 0 : record.box_min[a]);
}

// As many as the bytes have, at least 16, at most 200; every other one is in the box's frame.
inline std::vector<Segment> hostile_segments(HostileFloats floats, const ObjectRecord& record) {
  std::vector<Segment> segments;
  while (segments.size() < 16 || (segments.size() < 200 && !floats.at_end())) {
    Segment s{};
    const bool by_bytes = !floats.at_end();
    floats.next(s.origin), s.t_min = floats.next(), floats.next(s.direction), s.t_max = floats.next();
    if (!by_bytes) s.t_min = 0, s.t_max = 1 + 2 * floats.next();
    if (!by_bytes || segments.size() % 2) stretch(s.origin, record), stretch(s.direction, record, true);
    segments.push_back(s);
  }
  return segments;
}

struct HostileBundles {
  std::vector<float> columns[5];
  QuadBundle quad{};
  SphereBundle sphere{};

  HostileBundles(HostileFloats floats, const ObjectRecord& record) {
    const size_t count = 1 + floats.below(300);
    const bool in_box = floats.below(2);
    floats.next(quad.origin), floats.next(quad.corner), floats.next(quad.edge_u), floats.next(quad.edge_v);
    floats.next(sphere.centre), sphere.radius = floats.next();
    if (in_box) {
      stretch(quad.origin, record), stretch(quad.corner, record), stretch(sphere.centre, record);
      stretch(quad.edge_u, record, true), stretch(quad.edge_v, record, true);
      sphere.radius *= record.box_max[0] - record.box_min[0];
    }
    std::copy_n(quad.origin, 3, sphere.origin);
    for (size_t i = 0; i < count; ++i)
      for (size_t c = 0; c < 5; ++c)
        columns[c].push_back(c < 2 ? floats.next()
                                   : sphere.centre[c - 2] + 0.5f * sphere.radius * (floats.next() - 0.5f));
    quad.u = columns[0], quad.v = columns[1];
    sphere.x = columns[2], sphere.y = columns[3], sphere.z = columns[4];
  }
  HostileBundles(const HostileBundles&) = delete;
};

// Columns that end exactly where the segments end.
struct SegmentColumns {
  std::vector<float> columns[8];
  explicit SegmentColumns(std::span<const Segment> segments) {
    for (const Segment& s : segments) {
      float values[8];
      std::memcpy(values, &s, sizeof s);
      for (size_t c = 0; c < 8; ++c) columns[c].push_back(values[c]);
    }
  }
  SegmentArrays view() const {
    const auto at = [&](size_t c) { return columns[c].data(); };
    return {{at(0), at(1), at(2)}, at(3), {at(4), at(5), at(6)}, at(7), columns[0].size()};
  }
};

}  // namespace vcd::fuzz
