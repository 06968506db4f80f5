#include "weld.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace vcd {
namespace {

constexpr uint32_t kUnused = 0xFFFFFFFF;

// x * y == z * w, exactly: the product and its rounding error must both agree.
bool equal_products(double x, double y, double z, double w) {
  const double p = x * y, q = z * w;
  return p == q && std::fma(x, y, -p) == std::fma(z, w, -q);
}

// old index → index among the sorted unique positions; kUnused for positions that no triangle uses.
std::vector<uint32_t> sort_positions(const std::vector<Position>& positions, const std::vector<bool>& used,
                                     std::vector<Position>& unique) {
  std::vector<uint32_t> order;
  for (uint32_t i = 0; i < positions.size(); ++i)
    if (used[i]) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return positions[a] < positions[b]; });
  std::vector<uint32_t> remap(positions.size(), kUnused);
  for (uint32_t i : order) {
    if (unique.empty() || unique.back() != positions[i]) unique.push_back(positions[i]);
    remap[i] = static_cast<uint32_t>(unique.size() - 1);
  }
  return remap;
}

TriangleIndices ascending(TriangleIndices t) {
  std::sort(t.begin(), t.end());
  return t;
}

// Turns the corners round, without changing the winding, until the smallest comes first.
TriangleIndices smallest_first(TriangleIndices t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

}  // namespace

bool has_zero_area(const Position& a, const Position& b, const Position& c) {
  double e[3], f[3];
  for (int i = 0; i < 3; ++i) {
    e[i] = static_cast<double>(b[i]) - a[i];
    f[i] = static_cast<double>(c[i]) - a[i];
  }
  return equal_products(e[1], f[2], e[2], f[1]) && equal_products(e[2], f[0], e[0], f[2]) &&
         equal_products(e[0], f[1], e[1], f[0]);
}

void weld(SourceMesh&& source, PreparedMesh& mesh) {
  for (Position& p : source.positions)
    for (float& x : p) x += 0.0f;  // -0 becomes +0

  std::vector<bool> used(source.positions.size());
  std::erase_if(source.triangles, [&](const TriangleIndices& t) {
    const bool flat = has_zero_area(source.positions[t[0]], source.positions[t[1]], source.positions[t[2]]);
    mesh.zero_area_triangles += flat;
    if (!flat) used[t[0]] = used[t[1]] = used[t[2]] = true;
    return flat;
  });

  const std::vector<uint32_t> remap = sort_positions(source.positions, used, mesh.positions);
  source.positions = {};
  mesh.triangles = std::move(source.triangles);
  for (TriangleIndices& t : mesh.triangles) t = smallest_first({remap[t[0]], remap[t[1]], remap[t[2]]});

  // By ascending corners; of two windings of one triangle the smaller comes first and is kept.
  std::sort(mesh.triangles.begin(), mesh.triangles.end(), [](const TriangleIndices& a, const TriangleIndices& b) {
    return std::pair(ascending(a), a) < std::pair(ascending(b), b);
  });
  const auto end = std::unique(mesh.triangles.begin(), mesh.triangles.end(),
                               [](const auto& a, const auto& b) { return ascending(a) == ascending(b); });
  mesh.duplicate_triangles = static_cast<uint64_t>(mesh.triangles.end() - end);
  mesh.triangles.erase(end, mesh.triangles.end());
  mesh.triangles.shrink_to_fit();
}

}  // namespace vcd
