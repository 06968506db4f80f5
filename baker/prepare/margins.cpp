#include "prepare/margins.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <vcd/format/line_cell.h>

namespace vcd {
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
    for (size_t a = 0; a < 3; ++a) box.low[a] = std::min(box.low[a], corner[a]), box.high[a] = std::max(box.high[a], corner[a]);
  return box;
}

int square_of(double coordinate) { return std::clamp(static_cast<int>(std::floor(coordinate / kMapStep)), 0, kMap - 1); }

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

// Of square (i, j) of kMarginSquares from all that the map shows, in the largest of the three coordinates.
double distance(const Depths& depths, int i, int j) {
  constexpr int kSide = kMap / static_cast<int>(kMarginSquares);
  const auto gap = [](int from, int square) {
    const int low = from * kSide, high = low + kSide - 1;
    return kMapStep * std::max({low - square - 1, square - high - 1, 0});
  };
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kMap; ++k)
    for (int l = 0; l < kMap; ++l)
      nearest = std::min(nearest, std::max({depths[static_cast<size_t>(k * kMap + l)], gap(i, k), gap(j, l)}));
  return nearest;
}

}  // namespace

std::array<uint8_t, kMarginBytes> margins_of(const PreparedMesh& mesh) {
  std::array<Depths, 6> depths;
  for (Depths& map : depths) map.assign(size_t{kMap} * kMap, std::numeric_limits<double>::infinity());
  const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
  for (const auto& triangle : mesh.triangles) {
    Corners corners;
    for (size_t c = 0; c < 3; ++c)
      for (int a = 0; a < 3; ++a) corners[c][static_cast<size_t>(a)] = to_grid(frame, a, mesh.positions[triangle[c]][static_cast<size_t>(a)]);
    add(corners, depths);
  }
  std::array<uint8_t, kMarginBytes> margins;
  for (uint32_t face = 0; face < 6; ++face)
    for (uint32_t i = 0; i < kMarginSquares; ++i)
      for (uint32_t j = 0; j < kMarginSquares; ++j) {
        const double free = distance(depths[face], static_cast<int>(i), static_cast<int>(j)) - kMarginSlack;
        margins[(face * kMarginSquares + i) * kMarginSquares + j] = static_cast<uint8_t>(std::clamp(free, 0.0, 255.0));
      }
  return margins;
}

}  // namespace vcd
