#include <algorithm>
#include <cmath>

#include <vcd/scenes/generate.h>

#include "setting.h"

namespace vcd::scenes {
namespace {

constexpr uint32_t kMaxLevel = 12;

// Corner weights of a point of the pyramid: whole numbers that add up to 2^level. Two tetrahedra that touch compute
// their common corner from the same weights, and so to the same bits.
using Weights = std::array<uint32_t, 4>;

// A regular tetrahedron with edges of length 2, its base centred on the origin.
std::array<Double3, 4> pyramid_corners() {
  const double s = std::sqrt(1.0 / 3.0);
  return {{{-1, 0, s}, {1, 0, s}, {0, 0, -2 * s}, {0, std::sqrt(8.0 / 3.0), 0}}};
}

struct Pyramid {
  Mesh mesh;
  uint32_t level;
  std::array<Double3, 4> corners = pyramid_corners();

  Vec3 point(const Weights& w) const {
    Double3 sum;
    for (int c = 0; c < 4; ++c) sum = sum + static_cast<double>(w[c]) * corners[c];
    return to_float((1.0 / (1u << level)) * sum);
  }

  // The tetrahedron with edges of 2^depth steps whose corner c has `size` more of weight c than `base`.
  void divide(const Weights& base, uint32_t depth) {
    const uint32_t size = 1u << depth;
    if (depth == 0) return append(base);
    for (int c = 0; c < 4; ++c) {
      Weights w = base;
      w[c] += size / 2;
      divide(w, depth - 1);
    }
  }

  void append(const Weights& base) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (int c = 0; c < 4; ++c) {
      Weights w = base;
      ++w[c];
      mesh.positions.push_back(point(w));
    }
    for (const auto& [a, b, c] : {std::array{0u, 2u, 1u}, {0u, 1u, 3u}, {1u, 2u, 3u}, {2u, 0u, 3u}})
      mesh.triangles.push_back({first + a, first + b, first + c});
  }
};

}  // namespace

Scene sierpinski(uint32_t level) {
  Pyramid pyramid{.mesh = {}, .level = std::min(level, kMaxLevel)};
  const size_t triangle_count = size_t{4} << (2 * pyramid.level);
  pyramid.mesh.name = "sierpinski";
  pyramid.mesh.colour = {0.78f, 0.62f, 0.36f};
  pyramid.mesh.positions.reserve(triangle_count);
  pyramid.mesh.triangles.reserve(triangle_count);
  pyramid.divide({}, pyramid.level);

  Scene scene;
  scene.name = "sierpinski";
  scene.meshes.push_back(std::move(pyramid.mesh));
  scene.instances.push_back({0, kIdentity});
  put_in_setting(scene, {.turn = 0.035});
  return scene;
}

}  // namespace vcd::scenes
