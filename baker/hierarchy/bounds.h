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
  void add(const Bounds& other) {
    for (size_t a = 0; a < 3; ++a) min[a] = std::min(min[a], other.min[a]), max[a] = std::max(max[a], other.max[a]);
  }
  // Of a box that is not empty.
  float half_area() const {
    const float x = max[0] - min[0], y = max[1] - min[1], z = max[2] - min[2];
    return x * y + y * z + z * x;
  }
};

}  // namespace vcd::baker
