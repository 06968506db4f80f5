// Lines of a cell, and a referee for them in extended precision that shares nothing with the baker's proofs.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include <vcd/baker/cell.h>
#include <vcd/baker/prepare.h>
#include <vcd/format/line_cell.h>

namespace vcd::test {

using Point = std::array<long double, 3>;

struct Random {
  std::mt19937_64 engine;
  explicit Random(uint64_t seed) : engine(seed) {}
  uint32_t below(uint32_t n) { return static_cast<uint32_t>(engine() % n); }
  double uniform() { return static_cast<double>(engine() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * uniform(); }
};

struct Square3 {
  Point min, max;
};

// The squares of a cell on the faces of [0, 256]^3, low face's first, grown in all three directions.
inline std::array<Square3, 2> grown_squares(const baker::Cell& cell, long double growth) {
  const long double width = 256.0L / (1u << cell.level);
  const auto square = [&](uint32_t face, uint32_t first, uint32_t second) {
    const FaceAxes axes = face_axes(face);
    Square3 s;
    s.min[axes.normal] = s.max[axes.normal] = face % 2 ? 256 : 0;
    s.min[axes.first] = first * width, s.max[axes.first] = (first + 1) * width;
    s.min[axes.second] = second * width, s.max[axes.second] = (second + 1) * width;
    for (size_t a = 0; a < 3; ++a) s.min[a] -= growth, s.max[a] += growth;
    return s;
  };
  return {square(kFacePair[cell.pair].low, cell.s, cell.t), square(kFacePair[cell.pair].high, cell.u, cell.v)};
}

struct Range {
  long double low, high;
};

// For which t a point lies in (1 - t) A + t B: it is in the hull of two boxes if there is one.
inline std::optional<Range> steps_to(const Point& x, const Square3& a, const Square3& b) {
  Range t{0, 1};
  const auto require = [&](long double at0, long double at1) {  // a linear function of t that must not be negative
    if (at0 < 0 && at1 < 0) t = {1, 0};
    if (at0 < 0 && at1 >= 0) t.low = std::max(t.low, at0 / (at0 - at1));
    if (at0 >= 0 && at1 < 0) t.high = std::min(t.high, at0 / (at0 - at1));
  };
  for (size_t i = 0; i < 3; ++i) {
    require(x[i] - a.min[i], x[i] - b.min[i]);
    require(a.max[i] - x[i], b.max[i] - x[i]);
  }
  if (t.low > t.high) return std::nullopt;
  return t;
}

struct SegmentOfCell {
  Point from, to;
};

// A segment from one square to the other.
inline SegmentOfCell any_segment(const std::array<Square3, 2>& squares, Random& random) {
  SegmentOfCell s;
  for (size_t i = 0; i < 3; ++i) {
    const auto pick = [&](const Square3& q) {
      const uint32_t kind = random.below(6);
      const long double t = kind == 0 ? 0 : kind == 1 ? 1 : random.uniform();
      return q.min[i] + (q.max[i] - q.min[i]) * t;
    };
    s.from[i] = pick(squares[0]), s.to[i] = pick(squares[1]);
  }
  return s;
}

// The same through a point, if there is one.
inline std::optional<SegmentOfCell> segment_through(const Point& x, const std::array<Square3, 2>& squares,
                                                    Random& random) {
  const auto& [a, b] = squares;
  const auto steps = steps_to(x, a, b);
  if (!steps) return std::nullopt;
  const long double t = std::clamp(steps->low + (steps->high - steps->low) * random.uniform(), 1e-6L, 1 - 1e-6L);
  SegmentOfCell s;
  for (size_t i = 0; i < 3; ++i) {
    const long double low = std::max(a.min[i], (x[i] - t * b.max[i]) / (1 - t));
    const long double high = std::min(a.max[i], (x[i] - t * b.min[i]) / (1 - t));
    if (low > high) return std::nullopt;
    s.from[i] = low + (high - low) * (random.below(4) ? random.uniform() : random.below(2));
    s.to[i] = (x[i] - (1 - t) * s.from[i]) / t;
  }
  return s;
}

enum class Meets { no, unsure, yes };

// Whether a segment meets a triangle. Volumes below 256^3 are exact to 2^-38 here: unsure within 2^-30.
inline Meets meets(const SegmentOfCell& segment, const std::array<Point, 3>& triangle) {
  constexpr long double kUnsure = 0x1p-30L;
  Point d, p[3];
  for (size_t a = 0; a < 3; ++a) {
    d[a] = segment.to[a] - segment.from[a];
    for (size_t c = 0; c < 3; ++c) p[c][a] = triangle[c][a] - segment.from[a];
  }
  const auto volume = [&](const Point& q, const Point& r) {
    return d[0] * (q[1] * r[2] - q[2] * r[1]) + d[1] * (q[2] * r[0] - q[0] * r[2]) + d[2] * (q[0] * r[1] - q[1] * r[0]);
  };
  const long double v[3] = {volume(p[0], p[1]), volume(p[1], p[2]), volume(p[2], p[0])};
  int positive = 0, negative = 0;
  for (long double x : v) positive += x > kUnsure, negative += x < -kUnsure;
  if (positive > 0 && negative > 0) return Meets::no;
  if (positive < 3 && negative < 3) return Meets::unsure;
  long double along = 0, length2 = 0;
  for (size_t a = 0; a < 3; ++a) {
    along += d[a] * (p[0][a] * v[1] + p[1][a] * v[2] + p[2][a] * v[0]);
    length2 += d[a] * d[a];
  }
  const long double at = along / ((v[0] + v[1] + v[2]) * length2);
  if (at < -1e-9L || at > 1 + 1e-9L) return Meets::no;
  return at < 1e-9L || at > 1 - 1e-9L ? Meets::unsure : Meets::yes;
}

// The mesh in grid units without the rounding of positions_in_grid().
inline std::vector<std::array<Point, 3>> triangles_in_grid(const baker::PreparedMesh& mesh) {
  const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
  std::vector<std::array<Point, 3>> out;
  for (const baker::TriangleIndices& t : mesh.triangles) {
    auto& triangle = out.emplace_back();
    for (size_t c = 0; c < 3; ++c)
      for (size_t a = 0; a < 3; ++a)
        triangle[c][a] = (static_cast<long double>(mesh.positions[t[c]][a]) - frame.min[a]) * frame.scale[a];
  }
  return out;
}

// Whether a segment meets any of some triangles.
inline Meets meets_any(const SegmentOfCell& segment, std::span<const std::array<Point, 3>> triangles) {
  Meets most = Meets::no;
  for (const auto& triangle : triangles) {
    most = std::max(most, meets(segment, triangle));
    if (most == Meets::yes) break;
  }
  return most;
}

inline baker::Cell random_cell(uint32_t level, Random& random) {
  const uint32_t side = 1u << level;
  return {random.below(kFacePairs), level, random.below(side), random.below(side), random.below(side),
          random.below(side)};
}

// The cell of a level that a line through a point of the grid belongs to.
inline baker::Cell cell_of_line(const Point& through, uint32_t level, Random& random) {
  const float low[3] = {0, 0, 0}, high[3] = {256, 256, 256};
  const GridFrame frame = make_grid_frame(low, high);
  Segment s{};
  for (size_t a = 0; a < 3; ++a) {
    s.origin[a] = static_cast<float>(through[a]);
    s.direction[a] = static_cast<float>(random.between(-1, 1));
  }
  const LineCell line = locate(frame, s);
  const uint32_t up = 8 - level;
  return {line.pair, level, line.s >> up, line.t >> up, line.u >> up, line.v >> up};
}

}  // namespace vcd::test
