#include "crossings.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "classify/lanes.h"

namespace vcd {
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
    for (int a = 0; a < 3; ++a) corner[c][static_cast<size_t>(a)] = cluster.corner[c][a][k] - line.from[static_cast<size_t>(a)];
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

bool crossings(const TriangleGroups& groups, const Candidates& candidates, const Line& line, std::vector<Crossing>& into) {
  into.clear();
  std::array<double, 3> d;
  int main = 0;
  for (int a = 0; a < 3; ++a) {
    d[static_cast<size_t>(a)] = line.to[static_cast<size_t>(a)] - line.from[static_cast<size_t>(a)];
    if (std::abs(d[static_cast<size_t>(a)]) > std::abs(d[static_cast<size_t>(main)])) main = a;
  }
  // Seen along the line, in single precision: triangles whose bounding rectangle does not hold the line are out. Each
  // coordinate is exact to 2^-13: four roundings of numbers below 2^9.2, slopes of at most 1.
  constexpr float kViewError = 0x1p-12f;
  const int i = (main + 1) % 3, j = (main + 2) % 3;
  const auto slope = [&](int a) { return static_cast<float>(d[static_cast<size_t>(a)] / d[static_cast<size_t>(main)]); };
  const float from_main = static_cast<float>(line.from[static_cast<size_t>(main)]);
  bool sure = true;
  groups.for_each(candidates, [&](const TriangleCluster& cluster) {
    Floats low[2], high[2];
    int n = 0;
    for (int a : {i, j}) {
      const float from = static_cast<float>(line.from[static_cast<size_t>(a)]), rise = slope(a);
      const auto seen = [&](int c) {
        return (lanes(cluster.corner[c][a]) - from) - (lanes(cluster.corner[c][main]) - from_main) * rise;
      };
      const Floats x = seen(0), y = seen(1), z = seen(2);
      const Floats xy_low = x < y ? x : y, xy_high = x < y ? y : x;
      low[n] = xy_low < z ? xy_low : z;
      high[n++] = xy_high < z ? z : xy_high;
    }
    const Ints near = (low[0] <= kViewError) & (low[1] <= kViewError) & (high[0] >= -kViewError) & (high[1] >= -kViewError);
    for (uint32_t left = bits_of(near) & ((1u << cluster.count) - 1); left && sure; left &= left - 1) {
      const auto k = static_cast<uint32_t>(std::countr_zero(left));
      double at = 0;
      const Side side = side_of(line, d, cluster, k, at);
      if (side == Side::unsure) sure = false;
      if (side == Side::crosses) into.push_back({at, cluster.triangle[k]});
    }
    return sure;
  });
  std::sort(into.begin(), into.end(), [](const Crossing& x, const Crossing& y) {
    return x.at != y.at ? x.at < y.at : x.triangle < y.triangle;
  });
  return sure;
}

}  // namespace vcd
