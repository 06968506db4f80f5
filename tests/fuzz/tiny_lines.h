// Lines that a proof about a tiny mesh could get wrong.
#pragma once

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <vcd/baker/audit.h>
#include <vcd/baker/prepare.h>
#include <vcd/format/line_cell.h>

namespace vcd::fuzz {

using Point = std::array<double, 3>;

class TinyLines {
 public:
  TinyLines(const baker::PreparedMesh& mesh, uint32_t depth, uint64_t seed)
      : mesh_(mesh), side_(1u << depth), random_(seed) {
    for (size_t a = 0; a < 3; ++a) low_[a] = mesh.box_min[a], size_[a] = double{mesh.box_max[a]} - low_[a];
  }

  // From one point to another, and as far beyond both as it takes to pierce the box, or not.
  Segment through(const Point& from, const Point& to) {
    Segment s{};
    const double before = below(4) == 0 ? 0 : std::exp2(static_cast<double>(below(8)) - 1),
                 beyond = below(4) == 0 ? 0 : before + 1;
    for (size_t a = 0; a < 3; ++a) {
      s.origin[a] = static_cast<float>(from[a] - before * (to[a] - from[a]));
      s.direction[a] = static_cast<float>(to[a] + beyond * (to[a] - from[a]) - double{s.origin[a]});
    }
    s.t_max = below(8) ? 1 : 0x1p30f;
    return s;
  }

  // Corners and edges of cells on the faces of the box, now and then a hair beside.
  Point on_face() {
    const FaceAxes axes = face_axes(below(6));
    Point p;
    p[axes.normal] = below(2) ? 256 : 0;
    for (const uint8_t axis : {axes.first, axes.second}) {
      p[axis] = below(3) ? 256.0 / side_ * below(side_ + 1) : 256 * uniform();
      if (below(2)) p[axis] += 0.06 * (2 * uniform() - 1);
    }
    return in_object(p);
  }

  // A vertex, or a point of an edge or a triangle.
  Point on_mesh() {
    const baker::TriangleIndices& t = mesh_.triangles[below(static_cast<uint32_t>(mesh_.triangles.size()))];
    double weights[3] = {1, 0, 0};
    if (const uint32_t kind = below(3); kind > 0) {
      weights[1] = uniform(), weights[2] = kind > 1 ? (1 - weights[1]) * uniform() : 0;
      weights[0] = 1 - weights[1] - weights[2];
    }
    Point p{};
    for (size_t c = 0; c < 3; ++c)
      for (size_t a = 0; a < 3; ++a) p[a] += weights[c] * double{mesh_.positions[t[c]][a]};
    if (below(3) == 0)
      for (size_t a = 0; a < 3; ++a) p[a] += size_[a] * std::exp2(-8.0 - below(20)) * (2 * uniform() - 1);
    return p;
  }

  uint32_t below(uint32_t n) { return static_cast<uint32_t>(random_() % n); }

 private:
  double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  Point in_object(const Point& grid) const {
    Point p;
    for (size_t a = 0; a < 3; ++a) p[a] = low_[a] + grid[a] / 256 * size_[a];
    return p;
  }

  const baker::PreparedMesh& mesh_;
  uint32_t side_;
  Point low_, size_;
  std::mt19937_64 random_;
};

// Those of an audit, of every kind, and lines between corners of cells, vertices, edges and faces of the mesh.
inline std::vector<Segment> tiny_lines(const baker::PreparedMesh& mesh, uint32_t depth, uint64_t seed) {
  constexpr uint64_t kOfEachKind = 60;
  std::vector<Segment> lines;
  for (size_t kind = 0; kind < baker::kAuditKinds; ++kind) {
    const auto more = audit_segments(mesh, static_cast<baker::AuditKind>(kind), seed, kOfEachKind);
    lines.insert(lines.end(), more.begin(), more.end());
  }
  TinyLines tiny(mesh, depth, seed);
  for (uint64_t i = 0; i < 5 * kOfEachKind; ++i) {
    const Point from = tiny.below(3) ? tiny.on_face() : tiny.on_mesh(),
                to = tiny.below(3) ? tiny.on_mesh() : tiny.on_face();
    lines.push_back(tiny.through(from, to));
  }
  return lines;
}

}  // namespace vcd::fuzz
