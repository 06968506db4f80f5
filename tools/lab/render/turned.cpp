#include "turned.h"

#include <numbers>

namespace vcd::render {
namespace {

// About the ground's normal through a point (Rodrigues).
struct Turn {
  Vec3 axis, middle;
  float sine, cosine;

  Turn(const World& world, double degrees) : axis(world.ground.normal), middle(world.bounds.center()) {
    const double angle = degrees / 180 * std::numbers::pi;
    sine = static_cast<float>(std::sin(angle)), cosine = static_cast<float>(std::cos(angle));
  }
  Vec3 vector(Vec3 v) const { return v * cosine + cross(axis, v) * sine + axis * (dot(axis, v) * (1 - cosine)); }
  Vec3 point(Vec3 p) const { return vector(p - middle) + middle; }
};

}  // namespace

View turned_view(const World& world, double degrees) {
  const Turn turn(world, degrees);
  View view = world.view;
  view.position = turn.point(view.position);
  view.forward = turn.vector(view.forward), view.right = turn.vector(view.right), view.up = turn.vector(view.up);
  return view;
}

std::vector<Light> turned_lights(const World& world, double degrees) {
  const Turn turn(world, degrees);
  std::vector<Light> lights = world.lights;
  for (auto& [quad, radiance] : lights) {
    quad.corner = turn.point(quad.corner);
    quad.edge_u = turn.vector(quad.edge_u), quad.edge_v = turn.vector(quad.edge_v);
    quad.normal = turn.vector(quad.normal);
  }
  return lights;
}

}  // namespace vcd::render
