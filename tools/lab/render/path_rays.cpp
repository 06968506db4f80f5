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

class PathTracer {
 public:
  PathTracer(const World& world, uint64_t seed) : world_(world), random_(seed) {
    for (const WorldObject& object : world.objects) {
      const std::vector<uint32_t>& became = object.mesh.source_triangles;
      std::vector<uint32_t>& source = sources_.emplace_back(object.mesh.triangles.size());
      for (uint32_t i = 0; i < became.size(); ++i)
        if (became[i] != kNone) source[became[i]] = i;
    }
  }

  // One path that begins at the camera.
  void trace(uint32_t path, Vec3 direction, uint32_t bounces, std::vector<PathRay>& rays) {
    Vec3 origin = world_.view.position;
    for (uint32_t bounce = 1; bounce <= bounces; ++bounce) {
      const auto point = closest(origin, direction);
      if (!point) return;
      origin = point->position + point->normal * world_.shadow_offset;
      if (const auto segment = to_a_light(origin, point->normal))
        rays.push_back(
            {*segment, point->surface, source_of(*point), from_of(world_, point->surface, *segment), path, bounce});
      direction = cosine_direction(point->normal);
    }
  }

  Sample2 sample() {
    const float x = uniform();
    return {x, uniform()};
  }

 private:
  float uniform() { return static_cast<float>(random_() >> 40) * 0x1p-24f; }

  // Of the mesh's file, where the point is on a mesh.
  uint32_t source_of(const SurfacePoint& point) const {
    return point.surface == kGroundSurface ? kNoPrimitive
                                           : sources_[world_.instances[point.surface].object][point.primitive];
  }

  std::optional<SurfacePoint> closest(Vec3 o, Vec3 d) const {
    RTCRayHit ray{};
    ray.ray.org_x = o.x, ray.ray.org_y = o.y, ray.ray.org_z = o.z;
    ray.ray.dir_x = d.x, ray.ray.dir_y = d.y, ray.ray.dir_z = d.z;
    ray.ray.tfar = kInfinity, ray.ray.mask = 0xFFFFFFFF;
    ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(world_.visible.get(), &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return surface_point(world_, o, d, ray.ray.tfar, {ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z}, ray.hit.instID[0],
                         ray.hit.primID);
  }

  // All random numbers are drawn whatever becomes of them.
  std::optional<Segment> to_a_light(Vec3 origin, Vec3 normal) {
    const size_t choices = world_.lights.size() + 1;
    const size_t chosen = static_cast<size_t>(uniform() * static_cast<float>(choices));
    if (chosen >= world_.lights.size()) {
      const Vec3 d = cosine_direction(normal);
      if (dot(d, world_.ground.normal) <= 0) return std::nullopt;  // the ground, which casts no shadow, is all there is
      return Segment{{origin.x, origin.y, origin.z}, 0, {d.x, d.y, d.z}, kInfinity};
    }
    const Quad& quad = world_.lights[chosen].quad;
    const Sample2 at = sample();
    const Vec3 d = (quad.corner - origin) + quad.edge_u * at.x + quad.edge_v * at.y;
    if (dot(d, normal) <= 0 || dot(d, quad.normal) >= 0) return std::nullopt;
    return Segment{{origin.x, origin.y, origin.z}, 0, {d.x, d.y, d.z}, 1};
  }

  Vec3 cosine_direction(Vec3 normal) {
    const Sample2 at = sample();
    const float r = std::sqrt(at.x), phi = 2 * std::numbers::pi_v<float> * at.y;
    const Vec3 side = unit(cross(normal, std::fabs(normal.x) < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    return side * (r * std::cos(phi)) + cross(normal, side) * (r * std::sin(phi)) + normal * std::sqrt(1 - at.x);
  }

  const World& world_;
  std::vector<std::vector<uint32_t>> sources_;  // by object and triangle of its mesh
  std::mt19937_64 random_;
};

}  // namespace

std::vector<PathRay> trace_paths(const World& world, const PathSettings& settings) {
  const auto side = static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(settings.paths))));
  const Strata strata = make_strata(side * side);
  PathTracer tracer(world, settings.seed);
  std::vector<PathRay> rays;
  for (uint32_t path = 0; path < strata.corners.size(); ++path) {
    const Sample2 corner = strata.corners[path], inside = tracer.sample();
    const float x = corner.x + inside.x * strata.size.x, y = corner.y + inside.y * strata.size.y;
    tracer.trace(path, camera_direction(world.view, 3 * x, 2 * y, 3, 2), settings.bounces, rays);
  }
  return rays;
}

}  // namespace vcd::render
