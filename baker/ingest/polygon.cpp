#include "ingest/polygon.h"

#include <algorithm>
#include <cmath>

namespace vcd::baker {
namespace {

struct Point2 {
  double x, y;
};

// Twice the signed area. Coordinates are floats, so that the differences are exact or nearly so in double.
double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// The corners without those that repeat the one before (around the end too).
std::vector<uint32_t> without_repeats(std::span<const uint32_t> corners) {
  std::vector<uint32_t> kept;
  kept.reserve(corners.size());
  for (const uint32_t corner : corners) {
    if (kept.empty() || kept.back() != corner) kept.push_back(corner);
  }
  while (kept.size() > 1 && kept.front() == kept.back()) kept.pop_back();
  return kept;
}

bool has_three_distinct(const std::vector<uint32_t>& corners) {
  if (corners.size() < 3) return false;
  return std::any_of(corners.begin() + 2, corners.end(),
                     [&](uint32_t corner) { return corner != corners[0] && corner != corners[1]; });
}

// Newell's normal, of any length. Relative to the first corner, so that a far-away polygon keeps its digits.
std::array<double, 3> normal_of(std::span<const Position> positions, const std::vector<uint32_t>& corners) {
  const Position& origin = positions[corners[0]];
  const auto at = [&](size_t i, int axis) {
    return double{positions[corners[i % corners.size()]][axis]} - double{origin[axis]};
  };
  std::array<double, 3> normal = {0, 0, 0};
  for (size_t i = 0; i < corners.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      normal[axis] += at(i, u) * at(i + 1, v) - at(i, v) * at(i + 1, u);
    }
  }
  return normal;
}

// The axis in which the corners differ least: the view for a polygon without area, such as a bow tie.
int flattest_axis(std::span<const Position> positions, const std::vector<uint32_t>& corners) {
  std::array<double, 3> extent;
  for (int axis = 0; axis < 3; ++axis) {
    float least = positions[corners[0]][axis];
    float most = least;
    for (const uint32_t corner : corners) {
      least = std::min(least, positions[corner][axis]);
      most = std::max(most, positions[corner][axis]);
    }
    extent[axis] = double{most} - double{least};
  }
  return static_cast<int>(std::min_element(extent.begin(), extent.end()) - extent.begin());
}

// The polygon seen along the main axis of its normal, from the side where it runs counter-clockwise.
std::vector<Point2> project(std::span<const Position> positions, const std::vector<uint32_t>& corners) {
  const std::array<double, 3> normal = normal_of(positions, corners);
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(normal[i]) > std::abs(normal[axis])) axis = i;
  }
  if (normal[axis] == 0) axis = flattest_axis(positions, corners);
  int u = (axis + 1) % 3;
  int v = (axis + 2) % 3;
  if (normal[axis] < 0) std::swap(u, v);
  std::vector<Point2> points;
  points.reserve(corners.size());
  for (const uint32_t corner : corners) points.push_back({positions[corner][u], positions[corner][v]});
  return points;
}

// Every corner turns left, and the outline runs around once only (a pentagram turns left as well, but twice).
bool is_strictly_convex(const std::vector<Point2>& points) {
  const size_t n = points.size();
  int reversals = 0;
  bool rightwards = false;
  for (size_t i = 0; i < n + 1; ++i) {
    const Point2& a = points[i % n];
    const Point2& b = points[(i + 1) % n];
    if (!(turn(a, b, points[(i + 2) % n]) > 0)) return false;
    const bool now = b.x != a.x ? b.x > a.x : b.y < a.y;  // a tie is broken as if the view were tilted a little
    if (i > 0 && now != rightwards) ++reversals;
    rightwards = now;
  }
  return reversals == 2;
}

// Ear clipping over a ring of corners.
class EarClipper {
 public:
  explicit EarClipper(const std::vector<Point2>& points)
      : points_(points), next_(points.size()), previous_(points.size()), left_(points.size()) {
    for (size_t i = 0; i < left_; ++i) {
      next_[i] = (i + 1) % left_;
      previous_[i] = (i + left_ - 1) % left_;
    }
  }

  // Calls emit(a, b, c) for each of the n - 2 triangles. Returns false if one of them had to be what is no
  // ear.
  template <class Emit>
  bool run(Emit emit) {
    bool exact = true;
    size_t at = 0;
    while (left_ > 3) {
      const size_t ear = find_ear(at, exact);
      emit(previous_[ear], ear, next_[ear]);
      at = next_[ear];
      next_[previous_[ear]] = next_[ear];
      previous_[next_[ear]] = previous_[ear];
      --left_;
    }
    emit(previous_[at], at, next_[at]);
    return exact && corner_turn(at) >= 0;
  }

 private:
  // From the most to the least desirable: clear of every other corner; touched by others at most on its rim;
  // without area (a collinear corner). Failing all, any corner that turns left, or just any.
  enum class Quality { clear, touched, flat };

  size_t find_ear(size_t start, bool& exact) const {
    for (const Quality quality : {Quality::clear, Quality::touched, Quality::flat}) {
      size_t corner = start;
      do {
        if (is_ear(corner, quality)) return corner;
        corner = next_[corner];
      } while (corner != start);
    }
    exact = false;
    size_t corner = start;
    do {
      if (corner_turn(corner) > 0) return corner;
      corner = next_[corner];
    } while (corner != start);
    return start;
  }

  bool is_ear(size_t corner, Quality quality) const {
    const double own_turn = corner_turn(corner);
    if (quality == Quality::flat) return own_turn == 0;
    if (!(own_turn > 0)) return false;
    const Point2& a = points_[previous_[corner]];
    const Point2& b = points_[corner];
    const Point2& c = points_[next_[corner]];
    for (size_t i = next_[next_[corner]]; i != previous_[corner]; i = next_[i]) {
      const Point2& p = points_[i];
      if (same(p, a) || same(p, b) || same(p, c)) continue;  // a hole's bridge visits a corner twice
      const double least = std::min({turn(a, b, p), turn(b, c, p), turn(c, a, p)});
      if (quality == Quality::clear ? least >= 0 : least > 0) return false;
    }
    return true;
  }

  double corner_turn(size_t corner) const {
    return turn(points_[previous_[corner]], points_[corner], points_[next_[corner]]);
  }
  static bool same(const Point2& a, const Point2& b) { return a.x == b.x && a.y == b.y; }

  const std::vector<Point2>& points_;
  std::vector<size_t> next_, previous_;
  size_t left_;
};

}  // namespace

bool is_plane(std::span<const Position> positions, std::span<const uint32_t> corners) {
  const std::vector<uint32_t> all(corners.begin(), corners.end());
  const std::array<double, 3> n = normal_of(positions, all);
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  const Position& origin = positions[all[0]];
  double low = 0, high = 0, extent = 0;  // of the distances to a plane through the first corner, and along the axes
  for (const uint32_t corner : all) {
    double distance = 0;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double offset = double{positions[corner][axis]} - origin[axis];
      distance += n[axis] * offset;
      extent = std::max(extent, std::fabs(offset));
    }
    low = std::min(low, distance), high = std::max(high, distance);
  }
  return high - low <= 0x1p-12 * extent * length;
}

PolygonCut append_polygon(std::span<const Position> positions, std::span<const uint32_t> corners,
                          std::vector<TriangleIndices>& triangles) {
  const std::vector<uint32_t> kept = without_repeats(corners);
  if (!has_three_distinct(kept)) return PolygonCut::degenerate;
  const auto emit = [&](size_t a, size_t b, size_t c) { triangles.push_back({kept[a], kept[b], kept[c]}); };
  if (kept.size() == 3) {
    emit(0, 1, 2);
    return PolygonCut::exact;
  }
  const std::vector<Point2> points = project(positions, kept);
  if (is_strictly_convex(points)) {
    for (size_t i = 1; i + 1 < kept.size(); ++i) emit(0, i, i + 1);
    return PolygonCut::exact;
  }
  return EarClipper(points).run(emit) ? PolygonCut::exact : PolygonCut::forced;
}

}  // namespace vcd::baker
