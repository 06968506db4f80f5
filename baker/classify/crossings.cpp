#include "crossings.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

namespace vcd::baker {
namespace {

enum class Side { misses, crosses, unsure };

// An upper bound of the rounding error of edge() below. Coordinates seen from the line's beginning stay below 2^8.1 and
// the direction's below 2^8, so each of the six products of three is below 2^24.3; each goes through at most eight
// roundings of 2^-53: 6 · 2^24.3 · 8 · 2^-53 < 2^-23.
constexpr double kEdgeError = 0x1p-23;

// Six times the volume that the line spans with an edge: its sign tells on which side of the line the edge passes.
double edge(const std::array<double, 3>& d, const std::array<double, 3>& p, const std::array<double, 3>& q) {
  return d[0] * (p[1] * q[2] - p[2] * q[1]) + d[1] * (p[2] * q[0] - p[0] * q[2]) + d[2] * (p[0] * q[1] - p[1] * q[0]);
}

Side side_of(const Line& line, const std::array<double, 3>& d, const TriangleCluster& cluster, uint32_t k, double& at) {
  std::array<double, 3> corner[3];
  for (int c = 0; c < 3; ++c)
    for (size_t a = 0; a < 3; ++a) corner[c][a] = cluster.corner[c][a][k] - line.from[a];
  double volume[3];
  int positive = 0, negative = 0;
  for (int c = 0; c < 3; ++c) {
    volume[c] = edge(d, corner[c], corner[(c + 1) % 3]);
    positive += volume[c] > kEdgeError;
    negative += volume[c] < -kEdgeError;
  }
  if (positive > 0 && negative > 0) return Side::misses;
  if (positive < 3 && negative < 3) return Side::unsure;
  // Barycentric: each corner weighs as much as the edge opposite to it spans.
  const double sum = volume[0] + volume[1] + volume[2];
  double along = 0, length2 = 0;
  for (size_t a = 0; a < 3; ++a) {
    along += d[a] * (corner[0][a] * volume[1] + corner[1][a] * volume[2] + corner[2][a] * volume[0]);
    length2 += d[a] * d[a];
  }
  at = along / (sum * length2);
  return Side::crosses;
}

}  // namespace

bool crossings(const TriangleGroups& groups, const Candidates& candidates, const Line& line,
               std::vector<Crossing>& into) {
  into.clear();
  std::array<double, 3> d;
  uint32_t main = 0;
  for (uint32_t a = 0; a < 3; ++a) {
    d[a] = line.to[a] - line.from[a];
    if (std::abs(d[a]) > std::abs(d[main])) main = a;
  }
  // Seen along the line, in single precision: triangles whose bounding rectangle does not hold the line are out. Each
  // coordinate is exact to 2^-13: four roundings of numbers below 2^9.2, slopes of at most 1.
  constexpr float kViewError = 0x1p-12f;
  View view{main, (main + 1) % 3, (main + 2) % 3, {}, {}};
  for (size_t a = 0; a < 3; ++a) view.from[a] = static_cast<float>(line.from[a]);
  view.slope[0] = static_cast<float>(d[view.first] / d[main]);
  view.slope[1] = static_cast<float>(d[view.second] / d[main]);
  bool sure = true;
  groups.for_each(candidates, [&](const TriangleCluster& cluster) {
    for (uint32_t left = triangles_around(view, cluster, kViewError); left && sure; left &= left - 1) {
      const auto k = static_cast<uint32_t>(std::countr_zero(left));
      double at = 0;
      const Side side = side_of(line, d, cluster, k, at);
      if (side == Side::unsure) sure = false;
      if (side == Side::crosses) into.push_back({at, cluster.triangle[k]});
    }
    return sure;
  });
  std::sort(into.begin(), into.end(),
            [](const Crossing& x, const Crossing& y) { return x.at != y.at ? x.at < y.at : x.triangle < y.triangle; });
  return sure;
}

}  // namespace vcd::baker
