#include "setting.h"

#include <algorithm>
#include <limits>

namespace vcd::scenes {
namespace {

constexpr double kAspect = 1.5;  // of the pictures, width to height

Double3 apply(const Transform& t, const Vec3& p) {
  const auto row = [&](int r) {
    return double{t[r]} * p[0] + double{t[r + 1]} * p[1] + double{t[r + 2]} * p[2] + t[r + 3];
  };
  return {row(0), row(4), row(8)};
}

// The longest edge, or, for a box that has none to speak of, some steps of floats at its place.
double size_of(const Box& box) {
  const Double3 d = box.high - box.low;
  double far = 0;
  for (const Double3& p : {box.low, box.high}) far = std::max({far, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  const double size = std::max({d.x, d.y, d.z, far * 0x1p-21});
  return size > 0 ? size : 1;
}

template <class Visit>
void for_each_position(const Scene& scene, const Visit& visit) {
  for (const Instance& instance : scene.instances)
    for (const Vec3& position : scene.meshes[instance.mesh].positions) visit(apply(instance.transform, position));
}

struct Axes {
  Double3 right, up, back;  // of the picture, orthonormal
};

Axes axes_of(const View& view) {
  const CosSin e = at_turn(view.elevation), t = at_turn(view.turn);
  const Double3 back = {e.cos * t.sin, e.sin, e.cos * t.cos};
  const Double3 right = unit(cross(kUp, back));
  return {right, cross(back, right), back};
}

// How far back the camera must stand so that, about the target, no triangle reaches beyond `slope` of the picture.
double fitting_distance(const Scene& scene, const Axes& axes, Double3 target, double nearest, double slope) {
  double distance = nearest;
  for_each_position(scene, [&](Double3 at) {
    const Double3 p = at - target;
    const double half = std::max(std::fabs(dot(p, axes.right)) / kAspect, std::fabs(dot(p, axes.up)));
    distance = std::max(distance, half / slope + dot(p, axes.back));
  });
  return distance;
}

// From the target to the point whose image is the middle of the picture's occupied part.
Double3 off_centre(const Scene& scene, const Axes& axes, Double3 target, double distance) {
  double left = 0, right = 0, below = 0, above = 0;  // tangents of angles to the camera's axis
  for_each_position(scene, [&](Double3 at) {
    const Double3 p = at - target;
    const double depth = distance - dot(p, axes.back), x = dot(p, axes.right) / depth, y = dot(p, axes.up) / depth;
    left = std::min(left, x), right = std::max(right, x), below = std::min(below, y), above = std::max(above, y);
  });
  return (0.5 * distance) * ((left + right) * axes.right + (below + above) * axes.up);
}

Camera camera_before(const Scene& scene, const Box& box, const View& view) {
  Camera camera;
  const Axes axes = axes_of(view);
  const CosSin half = at_turn(camera.vertical_fov_degrees / 720.0);
  const double slope = view.fill * half.sin / half.cos, nearest = size_of(box);
  Double3 target = 0.5 * (box.low + box.high);
  double distance = fitting_distance(scene, axes, target, nearest, slope);
  for (int round = 0; round < 2; ++round) {
    target = target + off_centre(scene, axes, target, distance);
    distance = fitting_distance(scene, axes, target, nearest, slope);
  }
  camera.target = to_float(target);
  camera.position = to_float(target + distance * axes.back);
  return camera;
}

}  // namespace

Box bounds(const Scene& scene) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for_each_position(scene, [&](Double3 p) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  });
  return box.low.x <= box.high.x ? box : Box{};
}

AreaLight square_light(Double3 center, double side, Double3 lit, Double3 reflected) {
  const Double3 away = center - lit;
  const double distance2 = dot(away, away), cosine2 = away.y * away.y / distance2;
  const double half = 0.5 * side;
  AreaLight light;
  light.corner = to_float(center - Double3{half, 0, half});
  light.edge_u = to_float({side, 0, 0});
  light.edge_v = to_float({0, 0, side});
  light.radiance = to_float((kPi * distance2 / (cosine2 * side * side)) * reflected);
  return light;
}

void put_in_setting(Scene& scene, const View& view) {
  const Box box = bounds(scene);
  const double size = size_of(box);
  const Double3 middle = 0.5 * (box.low + box.high), foot = {middle.x, box.low.y, middle.z};
  scene.ground.height = static_cast<float>(box.low.y);
  scene.ground.center_x = static_cast<float>(middle.x);
  scene.ground.center_z = static_cast<float>(middle.z);
  scene.ground.half_size = static_cast<float>(30 * size);
  scene.camera = camera_before(scene, box, view);

  // The key light stands to the left and before the object, so that the shadow falls to the right; a weaker, cooler
  // one opposite lets the shadows keep their forms.
  const Double3 above = {middle.x, box.high.y, middle.z};
  const Double3 key = above + size * Double3{-1.25, 1.9, 0.7}, fill = above + size * Double3{1.3, 1.6, 0.9};
  const Double3 below_key = {key.x, foot.y, key.z};
  scene.lights = {square_light(key, 0.7 * size, below_key, {0.82, 0.77, 0.7}),
                  square_light(fill, 0.7 * size, below_key, {0.13, 0.145, 0.165})};
}

}  // namespace vcd::scenes
