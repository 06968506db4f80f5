#include "aimed_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include <vcd/format/line_cell.h>

#include "classify/random.h"
#include "prepare/topology.h"

namespace vcd::baker {
namespace {

using Vec = std::array<double, 3>;

Vec minus(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec mix(const Vec& a, const Vec& b, double t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The part of an edge that is inside all planes; false if there is none.
bool cut(const Shaft& shaft, SilhouetteEdge& edge) {
  double enter = 0, leave = 1;
  for (uint32_t k = 0; k < shaft.planes; ++k) {
    const Vec n = {shaft.normal[0][k], shaft.normal[1][k], shaft.normal[2][k]};
    const double from = dot(n, edge.from) - static_cast<double>(shaft.offset[k]);
    const double to = dot(n, edge.to) - static_cast<double>(shaft.offset[k]);
    if (from > 0 && to > 0) return false;
    if (from > 0) enter = std::max(enter, from / (from - to));
    if (to > 0) leave = std::min(leave, from / (from - to));
  }
  if (enter > leave) return false;
  edge = {mix(edge.from, edge.to, enter), mix(edge.from, edge.to, leave)};
  return true;
}

}  // namespace

void silhouette_edges(const TriangleGroups& groups, const Surface& surface, const Cell& cell, const Shaft& shaft,
                      const Candidates& candidates, size_t most, std::vector<SilhouetteEdge>& into) {
  into.clear();
  const auto [low, high] = squares(cell);
  const Vec along = minus(mix(high.min, high.max, 0.5), mix(low.min, low.max, 0.5));
  const auto corner = [&](uint32_t triangle, uint32_t c) {
    const Position& p = surface.corner(triangle, c);
    return Vec{p[0], p[1], p[2]};
  };
  const auto facing = [&](uint32_t triangle) {
    const Vec a = corner(triangle, 0);
    return dot(cross(minus(corner(triangle, 1), a), minus(corner(triangle, 2), a)), along) > 0;
  };
  const auto edge_of = [&](const TriangleCluster& cluster) -> std::optional<SilhouetteEdge> {
    for (uint32_t left = triangles_near(shaft, cluster); left; left &= left - 1) {
      const uint32_t triangle = cluster.triangle[std::countr_zero(left)];
      const bool faces = facing(triangle);
      for (uint32_t e = 0; e < 3; ++e) {
        const uint32_t neighbour = surface.neighbour(triangle, e);
        if (neighbour != kBoundary && (neighbour < triangle || facing(neighbour) == faces)) continue;
        SilhouetteEdge edge = {corner(triangle, e), corner(triangle, (e + 1) % 3)};
        if (cut(shaft, edge)) return edge;
      }
    }
    return std::nullopt;
  };
  // In strides, since clusters that are near in the list are near in space.
  const size_t count = candidates.size();
  size_t stride = count * 5 / 8;
  while (std::gcd(stride, count) > 1) ++stride;
  for (size_t i = 0; i < count && into.size() < most; ++i)
    groups.for_each(std::span(&candidates[i * stride % count], 1), [&](const TriangleCluster& cluster) {
      if (const auto edge = edge_of(cluster)) into.push_back(*edge);
      return into.size() < most;
    });
}

uint32_t aim_rays(const Cell& cell, uint64_t seed, const std::vector<SilhouetteEdge>& edges, RTCRay16& rays) {
  constexpr uint32_t kTries = 6;      // to find a line of the cell that passes a point of an edge
  constexpr double kBeside = 0x1p-8;  // how far beside, in widths of the cell
  const auto [low, high] = squares(cell);
  const uint32_t normal = face_axes(kFacePair[cell.pair].high).normal;
  const double width = double{kGrid} / (1u << cell.level);
  CellRandom random(cell, seed);
  float* const origin[3] = {rays.org_x, rays.org_y, rays.org_z};
  float* const direction[3] = {rays.dir_x, rays.dir_y, rays.dir_z};

  uint32_t count = 0;
  for (size_t i = 0; i < std::min<size_t>(edges.size(), 8); ++i) {
    const SilhouetteEdge& edge = edges[i];
    for (uint32_t attempt = 0; attempt < kTries; ++attempt) {
      const Vec point = mix(edge.from, edge.to, random.uniform());
      Vec from;
      for (size_t a = 0; a < 3; ++a) from[a] = low.min[a] + (low.max[a] - low.min[a]) * random.uniform();
      const Vec towards = minus(point, from);
      const Vec side = cross(minus(edge.to, edge.from), towards);
      const double length = std::sqrt(dot(side, side));
      if (!(length > 0)) continue;
      const uint32_t before = count;
      for (double sign : {-kBeside, kBeside}) {
        Vec d = minus(mix(point, {point[0] + side[0], point[1] + side[1], point[2] + side[2]}, sign * width / length),
                      from);
        const double stretch = (high.min[normal] - from[normal]) / d[normal];
        bool inside = stretch > 0;
        for (size_t a = 0; a < 3; ++a) {
          d[a] *= stretch;
          inside &= a == normal || (from[a] + d[a] >= high.min[a] && from[a] + d[a] <= high.max[a]);
        }
        if (!inside) continue;
        for (size_t a = 0; a < 3; ++a) {
          origin[a][count] = static_cast<float>(from[a]);
          direction[a][count] = static_cast<float>(d[a]);
        }
        ++count;
      }
      if (count > before) break;
    }
  }
  for (uint32_t k = 0; k < 16; ++k) {
    for (int a = 0; k >= count && count > 0 && a < 3; ++a) {
      origin[a][k] = origin[a][0];
      direction[a][k] = direction[a][0];
    }
    rays.tnear[k] = 0.0f;
    rays.tfar[k] = 1.0f;
    rays.time[k] = 0.0f;
    rays.mask[k] = 0xFFFFFFFF;
    rays.id[k] = 0;
    rays.flags[k] = 0;
  }
  return count;
}

}  // namespace vcd::baker
