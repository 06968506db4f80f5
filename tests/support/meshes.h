// Small meshes made on the spot.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include <vcd/baker/mesh.h>

namespace vcd::test {

inline baker::SourceMesh triangle() { return {"triangle", 0, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f}}, {{0, 1, 2}}}; }

inline baker::SourceMesh cube() {
  baker::SourceMesh mesh{"cube", 0, {}, {}};
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back({static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1), static_cast<float>(i >> 2)});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

inline baker::SourceMesh sphere(uint32_t rings = 24, uint32_t segments = 48) {
  baker::SourceMesh mesh{"sphere", 0, {}, {}};
  for (uint32_t r = 0; r <= rings; ++r)
    for (uint32_t s = 0; s < segments; ++s) {
      const double theta = std::numbers::pi * r / rings, phi = 2 * std::numbers::pi * s / segments;
      mesh.positions.push_back({static_cast<float>(std::sin(theta) * std::cos(phi)),
                                static_cast<float>(std::cos(theta)),
                                static_cast<float>(std::sin(theta) * std::sin(phi))});
    }
  for (uint32_t r = 0; r < rings; ++r)
    for (uint32_t s = 0; s < segments; ++s) {
      const uint32_t a = r * segments + s, b = r * segments + (s + 1) % segments;
      mesh.triangles.push_back({a, b, a + segments});
      mesh.triangles.push_back({b, b + segments, a + segments});
    }
  return mesh;
}

// Triangles that hang in the air, like leaves.
inline baker::SourceMesh leaves(uint32_t count, uint32_t seed = 1) {
  baker::SourceMesh mesh{"leaves", 0, {}, {}};
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  for (uint32_t i = 0; i < count; ++i) {
    const baker::Position base = {uniform() * 4, uniform() * 3, uniform() * 2};
    for (int corner = 0; corner < 3; ++corner)
      mesh.positions.push_back({base[0] + 0.3f * uniform(), base[1] + 0.3f * uniform(), base[2] + 0.3f * uniform()});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

}  // namespace vcd::test
