#include "triangle_groups.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <numeric>

namespace vcd::baker {
namespace {

// Splits order[first, last) so that each part but the last is a whole number of `unit` triangles.
void split(std::span<const Position> centroids, std::span<uint32_t> order, size_t unit) {
  if (order.size() <= kLanes) return;
  if (order.size() <= unit) unit = kLanes;
  Position low = centroids[order[0]], high = low;
  for (uint32_t t : order)
    for (int a = 0; a < 3; ++a)
      low[a] = std::min(low[a], centroids[t][a]), high[a] = std::max(high[a], centroids[t][a]);
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
  const size_t units = (order.size() + unit - 1) / unit;
  const size_t middle = std::max<size_t>(units / 2, 1) * unit;
  if (middle >= order.size()) return;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(middle), order.end(),
                   [&](uint32_t x, uint32_t y) {
                     return centroids[x][axis] != centroids[y][axis] ? centroids[x][axis] < centroids[y][axis] : x < y;
                   });
  split(centroids, order.first(middle), unit);
  split(centroids, order.subspan(middle), unit);
}

}  // namespace

TriangleGroups::TriangleGroups(std::span<const Position> positions, std::span<const TriangleIndices> triangles) {
  std::vector<Position> centroids(triangles.size());
  for (size_t t = 0; t < triangles.size(); ++t)
    for (int a = 0; a < 3; ++a)
      centroids[t][a] = positions[triangles[t][0]][a] + positions[triangles[t][1]][a] + positions[triangles[t][2]][a];
  std::vector<uint32_t> order(triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  split(centroids, order, kLanes * kLanes);

  for (size_t first = 0; first < order.size(); first += kLanes) {
    TriangleCluster& cluster = clusters_.emplace_back();
    cluster.count = static_cast<uint32_t>(std::min<size_t>(kLanes, order.size() - first));
    if (clusters_.size() % kLanes == 1) {
      groups_.emplace_back().first = static_cast<uint32_t>(clusters_.size() - 1);
      groups_.back().lanes = 0;
    }
    ClusterGroup& group = groups_.back();
    const size_t lane = (clusters_.size() - 1) % kLanes;
    group.lanes |= 1u << lane;
    for (int a = 0; a < 3; ++a) {
      group.min[a][lane] = std::numeric_limits<float>::infinity();
      group.max[a][lane] = -std::numeric_limits<float>::infinity();
    }
    for (uint32_t k = 0; k < kLanes; ++k) {
      const uint32_t t = order[first + std::min(k, cluster.count - 1)];
      cluster.triangle[k] = t;
      for (int c = 0; c < 3; ++c)
        for (int a = 0; a < 3; ++a) {
          const float x = positions[triangles[t][static_cast<size_t>(c)]][static_cast<size_t>(a)];
          cluster.corner[c][a][k] = x;
          group.min[a][lane] = std::min(group.min[a][lane], x);
          group.max[a][lane] = std::max(group.max[a][lane], x);
        }
    }
  }
}

Candidates TriangleGroups::all() const {
  Candidates candidates;
  for (uint32_t g = 0; g < groups_.size(); ++g) candidates.push_back({g, groups_[g].lanes});
  return candidates;
}

void TriangleGroups::select(const Shaft& shaft, const Candidates& from, Candidates& into) const {
  into.resize(from.size());
  into.resize(select_clusters(groups_.data(), shaft, from.data(), from.size(), into.data()));
}

bool TriangleGroups::any_meets(const Shaft& shaft, const Candidates& candidates) const {
  bool meets = false;
  for_each(candidates, [&](const TriangleCluster& cluster) {
    for (uint32_t left = triangles_near(shaft, cluster); left && !meets; left &= left - 1) {
      const int k = std::countr_zero(left);
      const auto corner = [&](int c) {
        return Position{cluster.corner[c][0][k], cluster.corner[c][1][k], cluster.corner[c][2][k]};
      };
      meets = triangle_meets(shaft, corner(0), corner(1), corner(2));
    }
    return !meets;
  });
  return meets;
}

bool triangle_meets(const Shaft& shaft, const Position& p, const Position& q, const Position& r) {
  // A corner of the polygon is its distances from all planes: cutting needs nothing else (Sutherland and Hodgman 1974).
  using Corner = std::array<double, kShaftPlanes>;
  constexpr size_t kMostCorners = 3 + kShaftPlanes + 2;
  std::array<Corner, kMostCorners> polygon, cut;
  size_t count = 0;
  for (const Position* x : {&p, &q, &r}) {
    bool inside = true;
    for (uint32_t k = 0; k < shaft.planes; ++k) {
      polygon[count][k] = static_cast<double>(shaft.normal[0][k]) * (*x)[0] +
                          static_cast<double>(shaft.normal[1][k]) * (*x)[1] +
                          static_cast<double>(shaft.normal[2][k]) * (*x)[2] - static_cast<double>(shaft.offset[k]);
      inside &= polygon[count][k] <= 0;
    }
    if (inside) return true;
    ++count;
  }
  for (uint32_t k = 0; k < shaft.planes; ++k) {
    size_t left = 0;
    for (size_t i = 0; i < count; ++i) {
      const Corner &from = polygon[i], &to = polygon[(i + 1) % count];
      if (left + 2 > kMostCorners) return true;  // rounding has made it concave: say what is safe
      if (from[k] <= 0) cut[left++] = from;
      if ((from[k] <= 0) != (to[k] <= 0)) {
        const double t = from[k] / (from[k] - to[k]);
        for (uint32_t j = 0; j < shaft.planes; ++j) cut[left][j] = from[j] + t * (to[j] - from[j]);
        cut[left++][k] = 0;
      }
    }
    if (left == 0) return false;
    count = left;
    std::swap(polygon, cut);
  }
  return true;
}

}  // namespace vcd::baker
