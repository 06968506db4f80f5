#include "path_rays.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

#include <vcd/format/layout.h>

#include "sampling.h"
#include "shadows.h"
#include "surface.h"

namespace vcd::render {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

float uniform(Random& random) { return static_cast<float>(random() >> 40) * 0x1p-24f; }

Vec3 cosine_direction(Vec3 normal, Sample2 at) {
  const float r = std::sqrt(at.x), phi = 2 * std::numbers::pi_v<float> * at.y;
  const Vec3 side = unit(cross(normal, std::fabs(normal.x) < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  return side * (r * std::cos(phi)) + cross(normal, side) * (r * std::sin(phi)) + normal * std::sqrt(1 - at.x);
}

std::optional<SurfacePoint> closest(const World& world, Vec3 o, Vec3 d) {
  RTCRayHit ray{};
  ray.ray.org_x = o.x, ray.ray.org_y = o.y, ray.ray.org_z = o.z;
  ray.ray.dir_x = d.x, ray.ray.dir_y = d.y, ray.ray.dir_z = d.z;
  ray.ray.tfar = kInfinity, ray.ray.mask = 0xFFFFFFFF;
  ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(world.visible.get(), &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return surface_point(world, o, d, ray.ray.tfar, {ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z}, ray.hit.instID[0],
                       ray.hit.primID);
}

// A shadow ray, and what a white surface at its origin sends back if nothing blocks it.
struct Lit {
  Segment segment;
  Vec3 light;
};

Segment segment_from(Vec3 origin, Vec3 direction, float t_max) {
  return {{origin.x, origin.y, origin.z}, 0, {direction.x, direction.y, direction.z}, t_max};
}

// All random numbers are drawn whatever becomes of them.
std::optional<Lit> to_a_light(const World& world, Vec3 origin, Vec3 normal, Random& random) {
  const size_t choices = world.lights.size() + 1;
  const size_t chosen = static_cast<size_t>(uniform(random) * static_cast<float>(choices));
  const Sample2 at = random_sample(random);
  const auto weight = static_cast<float>(choices);
  if (chosen >= world.lights.size()) {
    const Vec3 d = cosine_direction(normal, at);
    if (dot(d, world.ground.normal) <= 0) return std::nullopt;  // the ground, which casts no shadow, is all there is
    return Lit{segment_from(origin, d, kInfinity), kSky * weight};
  }
  const Light& light = world.lights[chosen];
  const Vec3 d = (light.quad.corner - origin) + light.quad.edge_u * at.x + light.quad.edge_v * at.y;
  const float at_surface = dot(d, normal), at_light = -dot(d, light.quad.normal), squared = dot(d, d);
  if (at_surface <= 0 || at_light <= 0) return std::nullopt;
  return Lit{segment_from(origin, d, 1), light.radiance * (weight * std::numbers::inv_pi_v<float> * light.quad.area *
                                                           (at_surface / squared) * (at_light / squared))};
}

}  // namespace

Sample2 random_sample(Random& random) {
  const float x = uniform(random);
  return {x, uniform(random)};
}

Met trace_path(const World& world, Random& random, uint32_t path, Vec3 direction, uint32_t bounces,
               std::vector<PathRay>& rays) {
  Vec3 origin = world.view.position, throughput = {1, 1, 1};
  Met met = Met::nothing;
  for (uint32_t bounce = 1; bounce <= bounces; ++bounce) {
    const auto point = closest(world, origin, direction);
    if (!point) return met;
    if (bounce == 1) met = point->surface == kGroundSurface ? Met::ground : Met::object;
    origin = point->position + point->normal * world.shadow_offset;
    throughput = throughput * point->colour;
    if (const auto lit = to_a_light(world, origin, point->normal, random)) {
      const From from = from_of(world, point->surface, lit->segment);
      rays.push_back({lit->segment, point->surface, point->primitive, from, path, bounce, throughput * lit->light});
    }
    direction = cosine_direction(point->normal, random_sample(random));
  }
  return met;
}

std::vector<PathRay> trace_paths(const World& world, const PathSettings& settings) {
  const auto side = static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(settings.paths))));
  const Strata strata = make_strata(side * side);
  Random random(settings.seed);
  std::vector<PathRay> rays;
  for (uint32_t path = 0; path < strata.corners.size(); ++path) {
    const Sample2 corner = strata.corners[path], inside = random_sample(random);
    const float x = corner.x + inside.x * strata.size.x, y = corner.y + inside.y * strata.size.y;
    trace_path(world, random, path, camera_direction(world.view, 3 * x, 2 * y, 3, 2), settings.bounces, rays);
  }
  return rays;
}

}  // namespace vcd::render
