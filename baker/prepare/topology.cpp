#include "topology.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace vcd::baker {
namespace {

// An edge shared by more triangles than this (a fan of a thousand, say) is a boundary of them all.
constexpr size_t kMostAtAnEdge = 16;

struct Side {          // of an edge: one triangle
  uint32_t low, high;  // the edge's vertices
  uint32_t slot;       // 3 · triangle + edge
  bool operator<(const Side& other) const {
    return std::tie(low, high, slot) < std::tie(other.low, other.high, other.slot);
  }
};

using Vec = std::array<double, 3>;

// The unit vector in the triangle's plane that points from the edge to the opposite corner.
Vec away_from_edge(std::span<const Position> positions, std::span<const TriangleIndices> triangles, const Side& side) {
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

std::vector<uint32_t> pair_edges(std::span<const Position> positions, std::span<const TriangleIndices> triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (uint32_t t = 0; t < triangles.size(); ++t)
    for (uint32_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(triangles[t][i], triangles[t][(i + 1) % 3]);
      sides.push_back({low, high, 3 * t + i});
    }
  std::sort(sides.begin(), sides.end());

  std::vector<uint32_t> neighbour(sides.size(), kBoundary);
  const auto join = [&](const Side& a, const Side& b) {
    neighbour[a.slot] = b.slot / 3;
    neighbour[b.slot] = a.slot / 3;
  };
  for (size_t first = 0, end; first < sides.size(); first = end) {
    end = first + 1;
    while (end < sides.size() && sides[end].low == sides[first].low && sides[end].high == sides[first].high) ++end;
    const size_t count = end - first;
    if (count == 2) join(sides[first], sides[first + 1]);
    if (count <= 2 || count > kMostAtAnEdge) continue;

    std::vector<Vec> away(count);
    for (size_t i = 0; i < count; ++i) away[i] = away_from_edge(positions, triangles, sides[first + i]);
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
      join(sides[first + best[0]], sides[first + best[1]]);
    }
  }
  return neighbour;
}

}  // namespace vcd::baker
