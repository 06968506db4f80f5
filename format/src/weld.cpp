#include <vcd/format/weld.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <vcd/format/layout.h>

namespace vcd {
namespace {

constexpr uint32_t kUnused = 0xFFFFFFFF;

// Whether six doubles sum to exactly zero, by error-free transformation (Shewchuk 1997, grow-expansion).
bool sums_to_zero(const std::array<double, 6>& terms) {
  double parts[6];
  int count = 0;
  for (double carry : terms) {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
      const double sum = carry + parts[i], virtual_part = sum - carry;
      const double error = (carry - (sum - virtual_part)) + (parts[i] - virtual_part);
      if (error != 0) parts[kept++] = error;
      carry = sum;
    }
    if (carry != 0) parts[kept++] = carry;
    count = kept;
  }
  return count == 0;
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

}  // namespace

bool has_zero_area(const Position& p, const Position& q, const Position& r) {
  // Products of two floats are exact in double. Twice the area of each projection, written without differences.
  const auto flat = [&](int i, int j) {
    const auto product = [](float x, float y) { return static_cast<double>(x) * y; };
    return sums_to_zero({product(p[i], q[j]), -product(p[j], q[i]), product(q[i], r[j]), -product(q[j], r[i]),
                         product(r[i], p[j]), -product(r[j], p[i])});
  };
  return flat(1, 2) && flat(2, 0) && flat(0, 1);
}

bool is_sound(std::span<const Position> positions, std::span<const TriangleIndices> triangles) {
  const auto finite = [](const Position& p) {
    return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
  };
  const auto inside = [&](const TriangleIndices& t) { return std::ranges::max(t) < positions.size(); };
  constexpr size_t kMost = 0xFFFFFFFF;  // numbers are 32 bits wide
  return positions.size() <= kMost && triangles.size() <= kMost && std::ranges::all_of(positions, finite) &&
         std::ranges::all_of(triangles, inside);
}

WeldedMesh weld(std::vector<Position>&& positions, std::vector<TriangleIndices>&& triangles) {
  WeldedMesh mesh;
  for (Position& p : positions)
    for (float& x : p) x += 0.0f;  // -0 becomes +0

  std::vector<bool> used(positions.size());
  struct Numbered {
    TriangleIndices corners;
    uint32_t source;
    auto operator<=>(const Numbered&) const = default;
  };
  std::vector<Numbered> numbered;
  mesh.source_triangles.assign(triangles.size(), kNone);
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    const TriangleIndices& t = triangles[i];
    const bool flat = has_zero_area(positions[t[0]], positions[t[1]], positions[t[2]]);
    mesh.zero_area_triangles += flat;
    if (!flat) used[t[0]] = used[t[1]] = used[t[2]] = true, numbered.push_back({t, i});
  }
  triangles = {};

  const std::vector<uint32_t> remap = sort_positions(positions, used, mesh.positions);
  positions = {};
  for (Numbered& t : numbered) t.corners = ascending({remap[t.corners[0]], remap[t.corners[1]], remap[t.corners[2]]});
  std::sort(numbered.begin(), numbered.end());
  for (const Numbered& t : numbered) {
    if (mesh.triangles.empty() || mesh.triangles.back() != t.corners) mesh.triangles.push_back(t.corners);
    mesh.source_triangles[t.source] = static_cast<uint32_t>(mesh.triangles.size() - 1);
  }
  mesh.duplicate_triangles = numbered.size() - mesh.triangles.size();
  mesh.triangles.shrink_to_fit();
  return mesh;
}

}  // namespace vcd
