#include "hierarchy/sample_rays.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "classify/random.h"

namespace vcd::baker {
namespace {

using Vec = std::array<double, 3>;

Vec sum(const Vec& a, double s, const Vec& b) { return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]}; }
double length(const Vec& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
Vec position(const PreparedMesh& mesh, uint32_t index) {
  const Position& p = mesh.positions[index];
  return {p[0], p[1], p[2]};
}

// Twice the area long.
Vec normal_of(const PreparedMesh& mesh, const TriangleIndices& t) {
  const Vec a = position(mesh, t[0]), e = sum(position(mesh, t[1]), -1, a), f = sum(position(mesh, t[2]), -1, a);
  return {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
}

// The numbers that belong to one ray.
class Random {
 public:
  Random(uint64_t seed, uint32_t number) : state_(mix_bits(seed + kGolden * (uint64_t{number} + 1))) {}
  double uniform() { return static_cast<double>(mix_bits(state_ += kGolden) >> 11) * 0x1p-53; }  // in [0, 1)

  // Of length 1. By rejection: sine and cosine are not the same on every machine, roots are.
  Vec direction() {
    for (;;) {
      const Vec v = {2 * uniform() - 1, 2 * uniform() - 1, 2 * uniform() - 1};
      const double l = length(v);
      if (l > 0.01 && l <= 1) return {v[0] / l, v[1] / l, v[2] / l};
    }
  }

 private:
  uint64_t state_;
};

SampleRay make_ray(const Vec& origin, const Vec& direction, float t_min, float t_max) {
  SampleRay ray{};
  const auto size = [&](uint32_t a) { return std::abs(direction[a]); };
  ray.z = size(0) > size(1) ? (size(0) > size(2) ? 0 : 2) : (size(1) > size(2) ? 1 : 2);
  ray.x = (ray.z + 1) % 3, ray.y = (ray.z + 2) % 3;
  for (size_t a = 0; a < 3; ++a) {
    ray.origin[a] = static_cast<float>(origin[a]);
    const double least = 1e-9 * size(ray.z);  // so that no product of its reciprocal overflows
    ray.reciprocal[a] = static_cast<float>(1 / std::copysign(std::max(std::abs(direction[a]), least), direction[a]));
  }
  ray.shear_x = static_cast<float>(direction[ray.x] / direction[ray.z]);
  ray.shear_y = static_cast<float>(direction[ray.y] / direction[ray.z]);
  ray.scale_z = static_cast<float>(1 / direction[ray.z]);
  ray.t_min = t_min, ray.t_max = t_max;
  return ray;
}

}  // namespace

SampleRays::SampleRays(const PreparedMesh& mesh, const Bounds& box) : mesh_(mesh), box_(box) {
  Vec diagonal;
  for (size_t a = 0; a < 3; ++a) diagonal[a] = static_cast<double>(box.max[a]) - box.min[a];
  length_ = length(diagonal);
  std::memcpy(&seed_, mesh.geometry_hash.data(), sizeof seed_);
  area_up_to_.reserve(mesh.triangles.size());
  double area = 0;
  for (const TriangleIndices& t : mesh.triangles) area_up_to_.push_back(area += length(normal_of(mesh, t)));
}

SampleRay SampleRays::operator()(uint32_t number) const {
  Random random(seed_, number);
  const Vec any = random.direction();
  if (number % 2 == 0) {
    Vec origin;
    for (size_t a = 0; a < 3; ++a)
      origin[a] = box_.min[a] + random.uniform() * (static_cast<double>(box_.max[a]) - box_.min[a]);
    return make_ray(origin, {any[0] * length_, any[1] * length_, any[2] * length_}, -1, 1);
  }
  const auto chosen =
      std::ranges::upper_bound(area_up_to_, random.uniform() * area_up_to_.back()) - area_up_to_.begin();
  const TriangleIndices& t = mesh_.triangles[std::min(static_cast<size_t>(chosen), mesh_.triangles.size() - 1)];
  double u = random.uniform(), v = random.uniform();
  if (u + v > 1) u = 1 - u, v = 1 - v;
  const Vec a = position(mesh_, t[0]), ab = sum(position(mesh_, t[1]), -1, a), ac = sum(position(mesh_, t[2]), -1, a);
  const Vec normal = normal_of(mesh_, t);
  const double size = length(normal), side = random.uniform() < 0.5 ? 1 : -1;
  Vec direction = sum(any, size > 0 ? side / size : 0, normal);
  if (length(direction) < 0.01) direction = any;
  // Begins a little away from the surface, so as not to meet it there.
  return make_ray(sum(sum(a, u, ab), v, ac), sum({}, length_, direction), 1e-4f, 2);
}

}  // namespace vcd::baker
