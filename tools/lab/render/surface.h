// What rays through a world's picture meet.
#pragma once

#include <embree3/rtcore.h>

#include "world.h"

namespace vcd::render {

struct SurfacePoint {
  Vec3 position, normal;  // the normal of unit length, towards where the ray came from
  Vec3 colour;
  uint32_t surface;    // an instance, or kGroundSurface
  uint32_t primitive;  // of that instance's source mesh; kNoPrimitive on the ground
};

// The point of world.visible that a ray met: Embree's hit, with its instance, triangle and normal (of any length).
SurfacePoint surface_point(const World& world, Vec3 origin, Vec3 direction, float t, Vec3 hit_normal,
                           uint32_t hit_instance, uint32_t hit_primitive);

// From the camera through a point of a picture of that size, x from its left and y from its top. Not of unit length.
Vec3 camera_direction(const View& view, float x, float y, float width, float height);

}  // namespace vcd::render
