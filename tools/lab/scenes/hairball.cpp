#include <algorithm>
#include <stdexcept>

#include <vcd/scenes/generate.h>

#include "setting.h"
#include "tube.h"

namespace vcd::scenes {
namespace {

// Units: the ball has a radius of about 1.
constexpr double kCoreRadius = 0.06;
constexpr double kRootRadius = 0.0055, kTipRadius = 0.002;

// One hair: it leaves the core, its course bends slowly this way and that, and the hair itself curls about that course.
// Near the rim the course is turned aside, which keeps the ball round and its outline soft.
void grow_hair(Random& random, std::vector<PathPoint>& path) {
  const double step = random.uniform(1.5, 2.4) / static_cast<double>(path.size() - 1);
  const double reach = random.uniform(0.86, 1.04), curl_lean = random.uniform(0.05, 0.12);
  const double hand = random.bits() & 1 ? 1 : -1, curl_step = hand * step * random.uniform(1.5, 4);
  Double3 course = random_direction(random), bend = random_direction(random);
  Double3 at = kCoreRadius * unit(course + 0.4 * random_direction(random));
  double curl = random.uniform();
  for (size_t i = 0; i < path.size(); ++i) {
    const double along = static_cast<double>(i) / static_cast<double>(path.size() - 1);
    path[i] = {at, kRootRadius + (kTipRadius - kRootRadius) * along};
    bend = unit(bend + 2.2 * std::sqrt(step) * random_direction(random));
    const double radius = length(at);
    const Double3 outward = (1 / radius) * at;
    const double excess = std::max(0.0, radius / reach - 0.6) / 0.4;  // 0 well inside, 1 at the rim
    const double heading_out = std::max(0.0, dot(course, outward) + 0.25 * excess);
    course = unit(course + 3 * step * bend - 9 * step * excess * heading_out * outward);
    curl += curl_step;
    at = at + step * leaning(course, curl_lean, curl);
  }
}

}  // namespace

uint64_t hairball_triangles(const HairballOptions& options) {
  return uint64_t{2} * options.strands * std::max(options.sides, 3u) * std::max(options.segments, 1u);
}

Scene hairball(const HairballOptions& options) {
  const uint32_t sides = std::max(options.sides, 3u), segments = std::max(options.segments, 1u);
  const uint64_t position_count = uint64_t{options.strands} * sides * (uint64_t{segments} + 1);
  if (position_count > UINT32_MAX) throw std::length_error("hairball: more points than 32-bit indices can name");
  Mesh mesh;
  mesh.name = "hairball";
  mesh.colour = {0.76f, 0.47f, 0.23f};
  mesh.positions.reserve(position_count);
  mesh.triangles.reserve(hairball_triangles(options));
  Random seeds(options.seed);
  std::vector<PathPoint> path(segments + 1);
  for (uint32_t s = 0; s < options.strands; ++s) {
    Random random = seeds.fork();  // a hair's own numbers: more segments leave the others' roots where they are
    grow_hair(random, path);
    append_tube(mesh, path, sides);
  }

  Scene scene;
  scene.name = "hairball";
  scene.meshes.push_back(std::move(mesh));
  scene.instances.push_back({0, kIdentity});
  put_in_setting(scene);
  return scene;
}

}  // namespace vcd::scenes
