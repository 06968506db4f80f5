#include "surface.h"

namespace vcd::render {
namespace {

Vec3 facing(Vec3 normal, Vec3 direction) { return dot(normal, direction) > 0 ? normal * -1 : normal; }

}  // namespace

SurfacePoint surface_point(const World& world, Vec3 origin, Vec3 direction, float t, Vec3 hit_normal,
                           uint32_t hit_instance, uint32_t hit_primitive) {
  const Vec3 position = origin + direction * t;
  if (hit_instance == RTC_INVALID_GEOMETRY_ID)
    return {position, facing(world.ground.normal, direction), world.ground_colour, kGroundSurface, kNoPrimitive};
  const uint32_t surface = hit_instance - 1;
  const WorldInstance& instance = world.instances[surface];
  const Vec3 normal = world.single() ? hit_normal : instance.to_object.transposed(hit_normal);
  const WorldObject& object = world.objects[instance.object];
  return {position, facing(unit(normal), direction), object.colour, surface, object.primitives[hit_primitive]};
}

Vec3 camera_direction(const View& view, float x, float y, float width, float height) {
  const float h = view.half_height;
  return view.forward + view.right * ((2 * x - width) / height * h) + view.up * ((1 - 2 * y / height) * h);
}

}  // namespace vcd::render
