#include "prepare/clearances.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <vcd/format/line_cell.h>

namespace vcd::baker {
namespace {

using Vec = std::array<double, 3>;
using Corners = std::array<Vec, 3>;

// Over each face a map of so many squares on a side: how deep below it the mesh begins.
constexpr int kMap = 64;
constexpr double kMapStep = kGrid / kMap;
using Depths = std::vector<double>;  // kMap × kMap

struct Box {
  Vec low, high;
};
Box box_of(const Corners& t) {
  Box box{t[0], t[0]};
  for (const Vec& corner : t)
    for (size_t a = 0; a < 3; ++a)
      box.low[a] = std::min(box.low[a], corner[a]), box.high[a] = std::max(box.high[a], corner[a]);
  return box;
}

int square_of(double coordinate) {
  return std::clamp(static_cast<int>(std::floor(coordinate / kMapStep)), 0, kMap - 1);
}

// Boxes stand for triangles; large ones are halved until theirs are small.
void add(const Corners& t, std::array<Depths, 6>& depths) {
  const Box box = box_of(t);
  double longest = 0;
  size_t from = 0;
  for (size_t e = 0; e < 3; ++e) {
    double length = 0;
    for (size_t a = 0; a < 3; ++a) length = std::max(length, std::abs(t[e][a] - t[(e + 1) % 3][a]));
    if (length > longest) longest = length, from = e;
  }
  if (longest > 2 * kMapStep) {
    Vec middle;
    for (size_t a = 0; a < 3; ++a) middle[a] = 0.5 * (t[from][a] + t[(from + 1) % 3][a]);
    const Vec &a = t[from], &b = t[(from + 1) % 3], &c = t[(from + 2) % 3];
    add({a, middle, c}, depths);
    add({middle, b, c}, depths);
    return;
  }
  for (uint32_t face = 0; face < 6; ++face) {
    const auto [normal, first, second] = face_axes(face);
    const double depth = face % 2 ? kGrid - box.high[normal] : box.low[normal];
    for (int i = square_of(box.low[first]); i <= square_of(box.high[first]); ++i)
      for (int j = square_of(box.low[second]); j <= square_of(box.high[second]); ++j) {
        double& known = depths[face][static_cast<size_t>(i * kMap + j)];
        known = std::min(known, depth);
      }
  }
}

// Along one axis of a face, from one of kClearanceSquares squares: the nearest of all places of the map, of which place
// k is away at(k) in the other coordinates. Away is the largest of the three coordinates.
template <class At>
double nearest_along(int square, const At& at) {
  constexpr int kSide = kMap / static_cast<int>(kClearanceSquares);
  const int low = square * kSide, high = low + kSide - 1;
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kMap; ++k)
    nearest = std::min(nearest, std::max(at(k), kMapStep * std::max({low - k - 1, k - high - 1, 0})));
  return nearest;
}

// Of each square of kClearanceSquares, row-major, from all that the map shows: along the rows, then across them.
std::vector<double> distances(const Depths& depths) {
  constexpr int kSquares = kClearanceSquares;
  std::vector<double> along, both;
  for (int k = 0; k < kMap; ++k)
    for (int j = 0; j < kSquares; ++j)
      along.push_back(nearest_along(j, [&](int l) { return depths[static_cast<size_t>(k * kMap + l)]; }));
  for (int i = 0; i < kSquares; ++i)
    for (int j = 0; j < kSquares; ++j)
      both.push_back(nearest_along(i, [&](int k) { return along[static_cast<size_t>(k * kSquares + j)]; }));
  return both;
}

}  // namespace

std::vector<uint8_t> clearances_of(const GridMesh& mesh) {
  std::array<Depths, 6> depths;
  for (Depths& map : depths) map.assign(size_t{kMap} * kMap, std::numeric_limits<double>::infinity());
  for (const TriangleIndices& t : mesh.triangles()) {
    const auto corner = [&](size_t c) {
      const Position& p = mesh.positions[t[c]];
      return Vec{p[0], p[1], p[2]};
    };
    add({corner(0), corner(1), corner(2)}, depths);
  }
  std::vector<uint8_t> clearances;
  clearances.reserve(kClearanceBytes);
  for (const Depths& map : depths)
    for (const double free : distances(map))
      clearances.push_back(static_cast<uint8_t>(std::clamp(free - kClearanceSlack, 0.0, 255.0)));
  return clearances;
}

}  // namespace vcd::baker
