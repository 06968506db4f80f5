#include "stability_meshes.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace vcd::bench {

using namespace baker;
namespace {

double uniform(Random& random) { return std::generate_canonical<double, 53>(random); }

using Vec = std::array<double, 3>;

Vec direction(Random& random) {
  const double z = 2 * uniform(random) - 1, phi = 2 * std::numbers::pi * uniform(random), r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}
Vec extent(const PreparedMesh& mesh) {
  Vec e;
  for (size_t a = 0; a < 3; ++a) e[a] = static_cast<double>(mesh.box_max[a]) - mesh.box_min[a];
  return e;
}
Vec point_in_box(const PreparedMesh& mesh, Random& random) {
  Vec p = extent(mesh);
  for (size_t a = 0; a < 3; ++a) p[a] = mesh.box_min[a] + p[a] * uniform(random);
  return p;
}
Vec point_on_mesh(const PreparedMesh& mesh, Random& random, bool vertex, bool edge) {
  const TriangleIndices& t = mesh.triangles[random() % mesh.triangles.size()];
  const double u = vertex ? 0 : edge ? uniform(random) : std::sqrt(uniform(random)), v = edge ? 0 : uniform(random);
  Vec p;
  for (size_t a = 0; a < 3; ++a) {
    const double x = mesh.positions[t[0]][a], y = mesh.positions[t[1]][a], z = mesh.positions[t[2]][a];
    p[a] = x + u * (y - x + v * (z - y));
  }
  return p;
}

// Passes a point, in units of the box along each axis, from `before` to `after` boxes on either side.
Segment through(const PreparedMesh& mesh, const Vec& point, const Vec& along, double before, double after) {
  const Vec e = extent(mesh);
  double boxes = 0;
  for (size_t a = 0; a < 3; ++a) boxes += std::abs(along[a]);
  Segment s{};
  for (size_t a = 0; a < 3; ++a) {
    s.origin[a] = static_cast<float>(point[a] - before / boxes * along[a] * e[a]);
    s.direction[a] = static_cast<float>(point[a] - static_cast<double>(s.origin[a]));
  }
  s.t_max = static_cast<float>((before + after) / before);
  return s;
}

void add_triangle(SourceMesh& mesh, const Position& a, const Position& b, const Position& c) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, b, c});
  mesh.triangles.push_back({first, first + 1, first + 2});
}

SourceMesh join(SourceMesh a, const SourceMesh& b) {
  const auto first = static_cast<uint32_t>(a.positions.size());
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  for (const TriangleIndices& t : b.triangles) a.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  return a;
}

// A strip around a circle that turns over once on its way.
SourceMesh moebius() {
  constexpr uint32_t kSteps = 60;
  SourceMesh mesh{"moebius", 0, {}, {}};
  for (uint32_t i = 0; i < kSteps; ++i)
    for (float side : {-0.35f, 0.35f}) {
      const float phi = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / kSteps,
                  r = 1 + side * std::cos(phi / 2);
      mesh.positions.push_back({r * std::cos(phi), r * std::sin(phi), side * std::sin(phi / 2)});
    }
  for (uint32_t i = 0; i < kSteps; ++i) {
    const bool last = i + 1 == kSteps;
    const uint32_t a = 2 * i, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({b, d, c});
  }
  return mesh;
}

}  // namespace

SourceMesh stability_sphere(uint32_t rings, uint32_t segments) {
  SourceMesh mesh{"sphere", 0, {{0, 1, 0}}, {}};
  const auto at = [&](uint32_t ring, uint32_t s) {
    return ring == 0 ? 0 : ring == rings ? 1 + (rings - 1) * segments : 1 + (ring - 1) * segments + s % segments;
  };
  for (uint32_t r = 1; r < rings; ++r)
    for (uint32_t s = 0; s < segments; ++s) {
      const double theta = std::numbers::pi * r / rings, phi = 2 * std::numbers::pi * s / segments;
      mesh.positions.push_back({static_cast<float>(std::sin(theta) * std::cos(phi)),
                                static_cast<float>(std::cos(theta)),
                                static_cast<float>(std::sin(theta) * std::sin(phi))});
    }
  mesh.positions.push_back({0, -1, 0});
  for (uint32_t r = 0; r < rings; ++r)
    for (uint32_t s = 0; s < segments; ++s) {
      if (r > 0) mesh.triangles.push_back({at(r, s), at(r, s + 1), at(r + 1, s)});
      if (r + 1 < rings) mesh.triangles.push_back({at(r, s + 1), at(r + 1, s + 1), at(r + 1, s)});
    }
  return mesh;
}

SourceMesh stability_slivers(uint32_t triangles, float aspect) {
  SourceMesh mesh{"slivers", 0, {}, {}};
  Random random(triangles);
  for (uint32_t i = 0; i < triangles; ++i) {
    const Vec along = direction(random), aside = direction(random);
    Position a, b, c;
    for (size_t k = 0; k < 3; ++k) {
      a[k] = static_cast<float>(uniform(random));
      b[k] = a[k] + 0.4f * static_cast<float>(along[k]);
      c[k] = a[k] + 0.2f * static_cast<float>(along[k]) + 0.4f / aspect * static_cast<float>(aside[k]);
    }
    add_triangle(mesh, a, b, c);
  }
  return mesh;
}

SourceMesh stability_soup(uint32_t triangles) {
  SourceMesh mesh{"soup", 0, {}, {}};
  Random random(triangles);
  const auto size = static_cast<float>(0.6 / std::cbrt(triangles));
  for (uint32_t i = 0; i < triangles; ++i) {
    Position base, corners[3];
    for (float& x : base) x = static_cast<float>(uniform(random));
    for (Position& corner : corners)
      for (size_t k = 0; k < 3; ++k) corner[k] = base[k] + size * static_cast<float>(uniform(random));
    add_triangle(mesh, corners[0], corners[1], corners[2]);
  }
  return mesh;
}

SourceMesh scaled(SourceMesh mesh, const Position& factor) {
  for (Position& p : mesh.positions)
    for (size_t a = 0; a < 3; ++a) p[a] *= factor[a];
  return mesh;
}

SourceMesh shifted(SourceMesh mesh, const Position& by) {
  for (Position& p : mesh.positions)
    for (size_t a = 0; a < 3; ++a) p[a] += by[a];
  return mesh;
}

std::vector<std::pair<std::string, SourceMesh>> stability_kinds(uint32_t soup_triangles) {
  const SourceMesh sphere = stability_sphere();
  SourceMesh open = sphere, inverted = sphere, duplicated = sphere;
  open.triangles.resize(open.triangles.size() / 2);
  for (TriangleIndices& t : inverted.triangles) std::swap(t[0], t[1]);
  for (TriangleIndices t : sphere.triangles) duplicated.triangles.push_back({t[1], t[0], t[2]});
  // A square of two triangles beside one of four: a vertex in the middle of an edge.
  SourceMesh junction{"t-junction", 0, {}, {}};
  add_triangle(junction, {0, 0, 0}, {1, 0, 0}, {1, 1, 0.2f}),
      add_triangle(junction, {0, 0, 0}, {1, 1, 0.2f}, {0, 1, 0.2f});
  add_triangle(junction, {1, 0, 0}, {2, 0, 0}, {1, 0.5f, 0.1f}),
      add_triangle(junction, {1, 0.5f, 0.1f}, {2, 0, 0}, {2, 1, 0.2f});
  add_triangle(junction, {1, 0.5f, 0.1f}, {2, 1, 0.2f}, {1, 1, 0.2f});
  SourceMesh bow_tie{"bow-tie", 0, {}, {}};
  add_triangle(bow_tie, {0, 0, 0}, {-1, -0.5f, 0.3f}, {-1, 0.5f, -0.2f}),
      add_triangle(bow_tie, {0, 0, 0}, {1, -0.5f, 0.1f}, {1, 0.5f, 0.4f});
  SourceMesh fins{"non-manifold", 0, {}, {}};
  for (int i = 0; i < 5; ++i) {
    const float phi = 1.2566f * static_cast<float>(i), c = std::cos(phi), s = std::sin(phi);
    add_triangle(fins, {0, 0, -1}, {0, 0, 1}, {c, s, 1}), add_triangle(fins, {0, 0, -1}, {c, s, 1}, {c, s, -1});
  }
  SourceMesh one{"triangle", 0, {}, {}};
  add_triangle(one, {0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f});
  return {{"closed", sphere},
          {"open", open},
          {"inverted", inverted},
          {"self-intersecting", join(sphere, shifted(sphere, {0.7f, 0.3f, 0.1f}))},
          {"duplicated", duplicated},
          {"T-junction", junction},
          {"bow-tie", bow_tie},
          {"non-manifold", fins},
          {"Möbius strip", moebius()},
          {"one triangle", one},
          {"soup", stability_soup(soup_triangles)}};
}

Segment through_the_box(const PreparedMesh& mesh, Random& random, double boxes) {
  return through(mesh, point_in_box(mesh, random), direction(random), std::max(boxes, 1e-3), boxes + 2);
}

SelfSegmentMaker above_a_triangle(double height) {
  return [height](const PreparedMesh& mesh, Random& random, uint32_t& triangle) {
    triangle = static_cast<uint32_t>(random() % mesh.triangles.size());
    Vec corner, a, b, n;
    double longest = 0, length2 = 0;
    for (size_t k = 0; k < 3; ++k) {
      const auto at = [&](size_t i) { return static_cast<double>(mesh.positions[mesh.triangles[triangle][i]][k]); };
      corner[k] = at(0), a[k] = at(1) - at(0), b[k] = at(2) - at(0);
      longest = std::max({longest, std::abs(a[k]), std::abs(b[k]), std::abs(at(2) - at(1))});
    }
    for (size_t k = 0; k < 3; ++k) {
      n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
      length2 += n[k] * n[k];
    }
    double u = uniform(random), v = uniform(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    if (const uint64_t place = random() % 12; place < 3) {
      u = place == 0 ? 0 : u, v = place == 1 ? 1 - u : place == 2 ? 0 : v;
      u += 1e-6 * (uniform(random) - 0.5);
    }
    const double side = (random() % 2 ? 1 : -1) / std::sqrt(length2);
    Vec d = direction(random);
    double up = 0;
    for (size_t k = 0; k < 3; ++k) n[k] *= side, up += d[k] * n[k];
    if (up < 0) {
      for (size_t k = 0; k < 3; ++k) d[k] = -d[k];
      up = -up;
    }
    const bool by_t = random() % 2;
    Segment s{};
    for (size_t k = 0; k < 3; ++k) {
      s.origin[k] = static_cast<float>(corner[k] + u * a[k] + v * b[k] + (by_t ? 0 : height * longest * n[k]));
      s.direction[k] = static_cast<float>(longest * d[k]);
    }
    s.t_min = by_t ? static_cast<float>(height / std::max(up, 1e-9)) : 0;
    s.t_max = std::numeric_limits<float>::infinity();
    return s;
  };
}

std::vector<std::pair<std::string, SegmentMaker>> segment_kinds() {
  const auto axis_of = [](Random& random) {
    Vec axis{};
    axis[random() % 3] = random() % 2 ? 1 : -1;
    return axis;
  };
  // A point of the box with `fixed` of its coordinates on the box's own bounds.
  const auto on_bounds = [](const PreparedMesh& mesh, Random& random, size_t fixed) {
    Vec p = point_in_box(mesh, random);
    const size_t first = random() % 3;
    for (size_t k = 0; k < fixed; ++k) {
      const size_t a = (first + k) % 3;
      p[a] = random() % 2 ? mesh.box_max[a] : mesh.box_min[a];
    }
    return p;
  };
  // From a point near the surface or the box outwards.
  const auto from = [](const PreparedMesh& mesh, const Vec& point, Random& random, double offset) {
    const Vec e = extent(mesh), d = direction(random);
    Segment s{};
    for (size_t a = 0; a < 3; ++a) {
      s.origin[a] = static_cast<float>(point[a] + offset * d[a] * e[a]);
      s.direction[a] = static_cast<float>(3 * d[a] * e[a]);
    }
    s.t_max = 1;
    return s;
  };
  return {
      {"along an axis",
       [=](const PreparedMesh& m, Random& r) { return through(m, point_in_box(m, r), axis_of(r), 2, 2); }},
      {"in a face of the box",
       [=](const PreparedMesh& m, Random& r) {
         const Vec p = on_bounds(m, r, 1);
         Vec d = direction(r);
         for (size_t a = 0; a < 3; ++a)
           if (p[a] == static_cast<double>(m.box_min[a]) || p[a] == static_cast<double>(m.box_max[a])) d[a] = 0;
         return through(m, p, d, 2, 2);
       }},
      {"through a box edge",
       [=](const PreparedMesh& m, Random& r) { return through(m, on_bounds(m, r, 2), direction(r), 2, 2); }},
      {"through a box corner",
       [=](const PreparedMesh& m, Random& r) { return through(m, on_bounds(m, r, 3), direction(r), 2, 2); }},
      {"in a triangle's plane",
       [=](const PreparedMesh& m, Random& r) {
         const TriangleIndices& t = m.triangles[r() % m.triangles.size()];
         const Position &a = m.positions[t[0]], &b = m.positions[t[1]], &c = m.positions[t[2]];
         const Vec e = extent(m);
         const double u = 3 * uniform(r) - 1, v = 2 * uniform(r) - 1, w = 2 * uniform(r) - 1;
         Vec p, d;
         for (size_t k = 0; k < 3; ++k) {
           const double ab = static_cast<double>(b[k]) - a[k], ac = static_cast<double>(c[k]) - a[k];
           p[k] = a[k] + u * ab + (1 - u) * 0.5 * ac;
           d[k] = (v * ab + w * ac) / e[k];
         }
         return through(m, p, d, 2, 2);
       }},
      {"at a vertex", [=](const PreparedMesh& m,
                          Random& r) { return through(m, point_on_mesh(m, r, true, false), direction(r), 2, 2); }},
      {"at an edge", [=](const PreparedMesh& m,
                         Random& r) { return through(m, point_on_mesh(m, r, false, true), direction(r), 2, 2); }},
      {"from the surface",
       [=](const PreparedMesh& m, Random& r) { return from(m, point_on_mesh(m, r, false, false), r, 0); }},
      {"from just off it",
       [=](const PreparedMesh& m, Random& r) { return from(m, point_on_mesh(m, r, false, false), r, 1e-5); }},
      {"from the box", [=](const PreparedMesh& m, Random& r) { return from(m, on_bounds(m, r, 1), r, 0); }},
      {"from just off the box", [=](const PreparedMesh& m, Random& r) { return from(m, on_bounds(m, r, 1), r, 1e-6); }},
  };
}

}  // namespace vcd::bench
