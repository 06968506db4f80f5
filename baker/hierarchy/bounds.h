// Boxes as the passes of the hierarchy's build use them.
#pragma once

#include <algorithm>
#include <limits>

#include <vcd/baker/mesh.h>

namespace vcd::baker {

struct Bounds {
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Position min{kInfinity, kInfinity, kInfinity}, max{-kInfinity, -kInfinity, -kInfinity};

  bool operator==(const Bounds&) const = default;

  void add(const Position& p) {
    for (size_t a = 0; a < 3; ++a) min[a] = std::min(min[a], p[a]), max[a] = std::max(max[a], p[a]);
  }
};

// A box in registers, for passes that join many: x, y, z and 0.
struct Box {
  using Lanes = float __attribute__((vector_size(16)));
  Lanes min, max;

  static Box of(const Bounds& b) {
    return {Lanes{b.min[0], b.min[1], b.min[2], 0}, Lanes{b.max[0], b.max[1], b.max[2], 0}};
  }
  Bounds bounds() const { return {{min[0], min[1], min[2]}, {max[0], max[1], max[2]}}; }
  bool operator==(const Box& other) const { return bounds() == other.bounds(); }

  void add(const Box& other) { add(other.min, other.max); }
  void add(const Lanes& low, const Lanes& high) { min = low < min ? low : min, max = max < high ? high : max; }
  float half_area() const {
    const Lanes size = max - min;
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
  }
};
inline Box together(Box a, const Box& b) {
  a.add(b);
  return a;
}

}  // namespace vcd::baker
