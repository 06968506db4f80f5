#include "shadow_rays.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace vcd::bench {

using namespace baker;

LightBundles shadow_rays(const PreparedMesh& mesh, size_t points, uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return std::generate_canonical<double, 53>(random); };
  double center[3], size[3];
  for (int a = 0; a < 3; ++a) {
    center[a] = (static_cast<double>(mesh.box_min[a]) + mesh.box_max[a]) / 2;
    size[a] = static_cast<double>(mesh.box_max[a]) - mesh.box_min[a];
  }
  const double width = std::max({size[0], size[1], size[2]});
  const auto light_width = static_cast<float>(0.6 * width);
  const double light[3] = {center[0] + 0.7 * width, center[1] + 0.5 * size[1] + 1.5 * width, center[2] + 0.3 * width};

  LightBundles rays;
  rays.u.reserve(points * kLightSamples), rays.v.reserve(points * kLightSamples);
  for (size_t p = 0; p < points; ++p) {
    const double point[3] = {center[0] + (2 * uniform() - 1.5) * width, mesh.box_min[1] - 0.01 * size[1],
                             center[2] + (2 * uniform() - 1) * width};
    // Strata of a grid of sixteen by eight, a block of four by four after the other.
    for (size_t s = 0; s < kLightSamples; ++s) {
      const size_t block = s / 16, column = block % 4 * 4 + s % 4, row = block / 4 * 4 + s / 4 % 4;
      rays.u.push_back(static_cast<float>((static_cast<double>(column) + uniform()) / 16));
      rays.v.push_back(static_cast<float>((static_cast<double>(row) + uniform()) / 8));
    }
    QuadBundle bundle{};
    for (int a = 0; a < 3; ++a) {
      bundle.origin[a] = static_cast<float>(point[a]);
      bundle.corner[a] = static_cast<float>(light[a]) - (a == 1 ? 0 : light_width / 2);
    }
    bundle.edge_u[0] = bundle.edge_v[2] = light_width;
    bundle.u = std::span(rays.u).last(kLightSamples), bundle.v = std::span(rays.v).last(kLightSamples);
    rays.bundles.push_back(bundle);
    for (size_t s = 0; s < kLightSamples; ++s) rays.segments.push_back(segment_of(bundle, s));
  }
  return rays;
}

std::vector<Segment> piercing_bundles(const PreparedMesh& mesh, size_t bundles, size_t samples, uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return std::generate_canonical<double, 53>(random); };
  double low[3], size[3];
  for (int a = 0; a < 3; ++a) {
    low[a] = mesh.box_min[a];
    size[a] = static_cast<double>(mesh.box_max[a]) - mesh.box_min[a];
  }
  const double width = std::max({size[0], size[1], size[2]});
  std::vector<Segment> segments;
  for (size_t b = 0; b < bundles; ++b) {
    const double z = 2 * uniform() - 1, phi = 6.283185307179586 * uniform(), r = std::sqrt(1 - z * z);
    const double away[3] = {3 * width * r * std::cos(phi), 3 * width * r * std::sin(phi), 3 * width * z};
    double center[3], origin[3];
    for (int a = 0; a < 3; ++a) {
      center[a] = low[a] + size[a] * (0.1 + 0.8 * uniform());
      origin[a] = low[a] + size[a] / 2 + away[a];
    }
    for (size_t s = 0; s < samples; ++s) {
      Segment segment{};
      for (int a = 0; a < 3; ++a) {
        const double target = center[a] + 0.1 * size[a] * (uniform() - 0.5);
        segment.origin[a] = static_cast<float>(origin[a]);
        segment.direction[a] = static_cast<float>(3 * (target - origin[a]));
      }
      segment.t_max = 1;
      segments.push_back(segment);
    }
  }
  return segments;
}

}  // namespace vcd::bench
