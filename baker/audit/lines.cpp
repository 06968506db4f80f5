#include "lines.h"

#include <cmath>
#include <numbers>

namespace vcd::baker {
namespace {

using Vec = std::array<double, 3>;

Vec mix(const Vec& a, const Vec& b, double t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}
Vec at(const Position& p) { return {p[0], p[1], p[2]}; }

Segment between(const Vec& from, const Vec& to) {
  Segment s{};
  for (int a = 0; a < 3; ++a) {
    s.origin[a] = static_cast<float>(from[a]);
    s.direction[a] = static_cast<float>(to[a] - from[a]);
  }
  s.t_min = 0;
  s.t_max = 1;
  return s;
}

}  // namespace

AuditLines::AuditLines(const PreparedMesh& mesh, AuditKind kind, uint64_t seed)
    : mesh_(mesh), kind_(kind), random_(seed * 16 + static_cast<uint64_t>(kind)) {
  radius_ = 0;
  for (int a = 0; a < 3; ++a) {
    center_[a] = (static_cast<double>(mesh.box_min[a]) + mesh.box_max[a]) / 2;
    half_[a] = (static_cast<double>(mesh.box_max[a]) - mesh.box_min[a]) / 2;
    radius_ = std::hypot(radius_, half_[a]);
  }
}

Vec AuditLines::direction() {
  const double z = 2 * uniform() - 1, phi = 2 * std::numbers::pi * uniform(), r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

Vec AuditLines::point_on_face(uint32_t face) {
  Vec p;
  for (uint32_t a = 0; a < 3; ++a) p[a] = center_[a] + half_[a] * (2 * uniform() - 1);
  p[face / 2] = center_[face / 2] + half_[face / 2] * (face % 2 ? 1 : -1);
  return p;
}

Vec AuditLines::point_on_mesh() {
  const auto& t = mesh_.triangles[random_() % mesh_.triangles.size()];
  const double u = std::sqrt(uniform()), v = uniform();
  const Vec a = at(mesh_.positions[t[0]]), b = at(mesh_.positions[t[1]]), c = at(mesh_.positions[t[2]]);
  return mix(a, mix(b, c, v), u);
}

Segment AuditLines::through(const Vec& point, Vec along) {
  if (uniform() < 0.05) {
    along = {};
    along[random_() % 3] = random_() % 2 ? 1 : -1;
  }
  double length = 0, boxes = 0;
  for (size_t i = 0; i < 3; ++i) {
    length = std::hypot(length, along[i]);
    boxes += std::abs(along[i]) / (2 * half_[i]);
  }
  // Ends beyond the box on both sides, a few boxes away; sometimes the beginning far away.
  const double after = radius_ * (2.1 + 6 * uniform()) / length;
  double before = radius_ * (2.1 + 6 * uniform()) / length;
  if (uniform() < 0.1) before = std::max(before, std::pow(500.0, uniform()) / boxes);
  // The direction leads from the rounded origin to the point, so that the line misses the point by its rounding alone.
  Segment s{};
  for (size_t i = 0; i < 3; ++i) {
    s.origin[i] = static_cast<float>(point[i] - before * along[i]);
    s.direction[i] = static_cast<float>(point[i] - static_cast<double>(s.origin[i]));
  }
  s.t_max = static_cast<float>((before + after) / before);
  if (uniform() < 0.1) shorten(s);
  return s;
}

// Begins or ends shortly behind the box's surface, as what stands on the ground sees it.
void AuditLines::shorten(Segment& s) {
  double enter = s.t_min, leave = s.t_max;
  for (size_t i = 0; i < 3; ++i) {
    const double o = s.origin[i], d = s.direction[i];
    const double t0 = (center_[i] - half_[i] - o) / d, t1 = (center_[i] + half_[i] - o) / d;
    if (d == 0) continue;
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  if (!(enter < leave)) return;
  const double part = (leave - enter) * std::pow(2.0, -10 + 8 * uniform());
  if (random_() % 2) s.t_min = static_cast<float>(enter + part);
  else s.t_max = static_cast<float>(leave - part);
}

Segment AuditLines::next() {
  switch (kind_) {
    case AuditKind::uniform: {
      const uint32_t first = static_cast<uint32_t>(random_() % 6);
      const uint32_t second = (first + 1 + static_cast<uint32_t>(random_() % 5)) % 6;
      const Vec a = point_on_face(first);
      const Vec b = point_on_face(second);
      return through(mix(a, b, uniform()), {b[0] - a[0], b[1] - a[1], b[2] - a[2]});
    }
    case AuditKind::chords: {
      // An isotropic line through the box's sphere; those that miss the box are drawn again, with a cheap test.
      const Vec d = direction();
      Vec p;
      do {
        const Vec q = direction();
        const double r = radius_ * std::sqrt(uniform());
        const double along = q[0] * d[0] + q[1] * d[1] + q[2] * d[2];
        Vec flat{q[0] - along * d[0], q[1] - along * d[1], q[2] - along * d[2]};
        const double length = std::hypot(flat[0], flat[1], flat[2]);
        for (int a = 0; a < 3; ++a) p[a] = center_[a] + flat[a] / length * r;
      } while ([&] {
        double enter = -1e30, leave = 1e30;
        for (int a = 0; a < 3; ++a) {
          const double t0 = (center_[a] - half_[a] - p[a]) / d[a], t1 = (center_[a] + half_[a] - p[a]) / d[a];
          enter = std::max(enter, std::min(t0, t1));
          leave = std::min(leave, std::max(t0, t1));
        }
        return !(enter < leave);
      }());
      return through(p, d);
    }
    case AuditKind::inside: {
      const Vec p = point_on_mesh(), d = direction();
      const double start = radius_ * 1e-3 * uniform(), end = radius_ * (0.1 + 4 * uniform());
      return between({p[0] + start * d[0], p[1] + start * d[1], p[2] + start * d[2]},
                     {p[0] + end * d[0], p[1] + end * d[1], p[2] + end * d[2]});
    }
    case AuditKind::edges:
    case AuditKind::vertices: {
      const auto& t = mesh_.triangles[random_() % mesh_.triangles.size()];
      const uint32_t corner = static_cast<uint32_t>(random_() % 3);
      const Vec a = at(mesh_.positions[t[corner]]), b = at(mesh_.positions[t[(corner + 1) % 3]]), d = direction();
      const Vec p = kind_ == AuditKind::vertices ? a : mix(a, b, uniform());
      return through(p, d);
    }
  }
  return {};
}

}  // namespace vcd::baker
