// The hierarchy over the instances' boxes: nodes of sixteen boxes, and which of them a segment or a beam could meet.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vcd {

inline constexpr size_t kBoxes = 16;

// Empty places have boxes that nothing meets.
struct SceneNode {
  alignas(64) float side[2][3][kBoxes];  // low and high, by axis
  uint32_t child[kBoxes];                // a node, or an instance with kLeaf set
};
inline constexpr uint32_t kLeaf = 0x80000000;
inline constexpr uint32_t kAgain = 0x40000000;  // of an instance: the next box is its, too
inline constexpr size_t kMostSceneLevels = 16;

// A segment as the hierarchy is asked with it.
struct SceneRay {
  float origin[3], inverse[3], t_min, t_max;
  uint32_t first[3];  // the side that the segment enters by
};
inline constexpr float kBoxSlack = 0x1p-20f;  // of t: covers the rounding of a box test several times

// Segments from a box of origins, with a box of directions: at t they are within [origin_low + t · low, origin_high + t
// · high].
struct SceneBeam {
  float origin_low[3], origin_high[3];
  float inverse_low[3], inverse_high[3];  // of the directions' bounds
  float t_max;                            // from t = 0
};

// Whether a box is entered, within rounding, before it is left.
inline bool meets(float near, float far) {
  return near - std::abs(near) * kBoxSlack <= far + std::abs(far) * kBoxSlack;
}

// A bit for each box that the segment could meet.
inline uint32_t boxes_met(const SceneNode& node, const SceneRay& ray) {
  uint32_t met = 0;
  for (size_t i = 0; i < kBoxes; ++i) {
    float near = ray.t_min, far = ray.t_max;
    for (int a = 0; a < 3; ++a) {
      near = std::max(near, (node.side[ray.first[a]][a][i] - ray.origin[a]) * ray.inverse[a]);
      far = std::min(far, (node.side[ray.first[a] ^ 1][a][i] - ray.origin[a]) * ray.inverse[a]);
    }
    met |= uint32_t{meets(near, far)} << i;
  }
  return met;
}

// A bit for each box that the beam could meet.
inline uint32_t boxes_in_beam(const SceneNode& node, const SceneBeam& beam) noexcept {
  uint32_t met = 0;
  for (size_t i = 0; i < kBoxes; ++i) {
    float near = 0, far = beam.t_max;
    for (int a = 0; a < 3; ++a) {
      const float low = (node.side[1][a][i] - beam.origin_low[a]) * beam.inverse_low[a];
      const float high = (node.side[0][a][i] - beam.origin_high[a]) * beam.inverse_high[a];
      (beam.inverse_low[a] < 0 ? near : far) = beam.inverse_low[a] < 0 ? std::max(near, low) : std::min(far, low);
      (beam.inverse_high[a] > 0 ? near : far) = beam.inverse_high[a] > 0 ? std::max(near, high) : std::min(far, high);
    }
    met |= uint32_t{meets(near, far)} << i;
  }
  return met;
}

}  // namespace vcd
