#include "topology.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "disjoint_sets.h"

namespace vcd::baker {
namespace {

// An edge shared by more triangles than this (a fan of a thousand, say) is a boundary of them all.
constexpr size_t kMostAtAnEdge = 16;

using Vec = std::array<double, 3>;

// The unit vector in the triangle's plane that points from the edge to the opposite corner.
Vec away_from_edge(std::span<const Position> positions, std::span<const TriangleIndices> triangles,
                   const EdgeSide& side) {
  const Position &p = positions[side.low], &q = positions[side.high];
  const Position& r = positions[triangles[side.slot / 3][(side.slot % 3 + 2) % 3]];
  Vec edge, away;
  double edge2 = 0, along = 0, length2 = 0;
  for (int a = 0; a < 3; ++a) {
    edge[a] = static_cast<double>(q[a]) - p[a];
    away[a] = static_cast<double>(r[a]) - p[a];
    edge2 += edge[a] * edge[a];
    along += edge[a] * away[a];
  }
  for (int a = 0; a < 3; ++a) {
    away[a] -= edge[a] * (along / edge2);
    length2 += away[a] * away[a];
  }
  for (double& x : away) x /= std::sqrt(length2);
  return away;
}

}  // namespace

std::vector<EdgeSide> edge_sides(std::span<const TriangleIndices> triangles) {
  std::vector<EdgeSide> sides;
  sides.reserve(3 * triangles.size());
  for (uint32_t t = 0; t < triangles.size(); ++t)
    for (uint32_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(triangles[t][i], triangles[t][(i + 1) % 3]);
      sides.push_back({low, high, 3 * t + i});
    }
  std::sort(sides.begin(), sides.end(), [](const EdgeSide& a, const EdgeSide& b) {
    return std::tie(a.low, a.high, a.slot) < std::tie(b.low, b.high, b.slot);
  });
  return sides;
}

std::vector<uint32_t> corner_fans(std::span<const TriangleIndices> triangles, std::span<const EdgeSide> sides) {
  DisjointSets corners(3 * triangles.size());
  const auto corner_at = [&](const EdgeSide& side, uint32_t vertex) {
    const uint32_t t = side.slot / 3, i = side.slot % 3;
    return 3 * t + (triangles[t][i] == vertex ? i : (i + 1) % 3);
  };
  for_each_edge(sides, [&](std::span<const EdgeSide> edge) {
    for (const EdgeSide& side : edge.subspan(1))
      for (const uint32_t vertex : {side.low, side.high})
        corners.join(corner_at(edge[0], vertex), corner_at(side, vertex));
  });
  std::vector<uint32_t> fans(3 * triangles.size());
  for (uint32_t corner = 0; corner < fans.size(); ++corner) fans[corner] = corners.root(corner);
  return fans;
}

std::vector<uint32_t> pair_edges(std::span<const Position> positions, std::span<const TriangleIndices> triangles) {
  std::vector<uint32_t> neighbour(3 * triangles.size(), kBoundary);
  const auto join = [&](const EdgeSide& a, const EdgeSide& b) {
    neighbour[a.slot] = b.slot / 3;
    neighbour[b.slot] = a.slot / 3;
  };
  for_each_edge(edge_sides(triangles), [&](std::span<const EdgeSide> sides) {
    const size_t count = sides.size();
    if (count == 2) join(sides[0], sides[1]);
    if (count <= 2 || count > kMostAtAnEdge) return;

    std::vector<Vec> away(count);
    for (size_t i = 0; i < count; ++i) away[i] = away_from_edge(positions, triangles, sides[i]);
    std::vector<bool> taken(count);
    for (size_t pairs = count / 2; pairs > 0; --pairs) {
      size_t best[2] = {};
      double straightest = std::numeric_limits<double>::infinity();
      for (size_t i = 0; i < count; ++i)
        for (size_t j = i + 1; j < count; ++j) {
          const double dot = away[i][0] * away[j][0] + away[i][1] * away[j][1] + away[i][2] * away[j][2];
          if (!taken[i] && !taken[j] && dot < straightest) straightest = dot, best[0] = i, best[1] = j;
        }
      if (best[0] == best[1]) break;  // numbers that do not compare
      taken[best[0]] = taken[best[1]] = true;
      join(sides[best[0]], sides[best[1]]);
    }
  });
  return neighbour;
}

}  // namespace vcd::baker
