#include "surface.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include <meshoptimizer.h>

#include <vcd/format/tree.h>

#include "info/cell_of_line.h"

namespace vcd::tools {

using namespace baker;
namespace {

constexpr size_t kFineTriangles = 20'000;  // meshes are cut to no more than these
constexpr size_t kJudgedLines = 500'000;   // of all places together: some seconds of work

Position middle(const Position& a, const Position& b) {
  Position m;
  for (size_t i = 0; i < 3; ++i) m[i] = a[i] + (b[i] - a[i]) / 2;
  return m;
}

DrawnSurface cut(DrawnSurface surface) {
  std::vector<TriangleIndices> triangles;
  std::vector<uint32_t> source;
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto [a, b, c] = surface.triangles[t];
    auto& p = surface.positions;
    const auto ab = static_cast<uint32_t>(p.size()), bc = ab + 1, ca = ab + 2;
    p.insert(p.end(), {middle(p[a], p[b]), middle(p[b], p[c]), middle(p[c], p[a])});
    triangles.insert(triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    source.insert(source.end(), 4, surface.source[t]);
  }
  surface.triangles = std::move(triangles), surface.source = std::move(source);
  return surface;
}

DrawnSurface thinned(const PreparedMesh& mesh, size_t most) {
  std::vector<uint32_t> indices(3 * mesh.triangles.size());
  // The sloppy one: it needs no winding and thins hair and foliage too.
  indices.resize(meshopt_simplifySloppy(indices.data(), mesh.triangles[0].data(), indices.size(),
                                        mesh.positions[0].data(), mesh.positions.size(), sizeof(Position), 3 * most,
                                        1.0f));
  indices.resize(std::min(indices.size() / 3, most) * 3);
  std::vector<uint32_t> triangle_at(mesh.positions.size());
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const uint32_t vertex : mesh.triangles[t]) triangle_at[vertex] = t;
  DrawnSurface surface;
  surface.thinned = true;
  std::map<uint32_t, uint32_t> numbers;
  for (size_t i = 0; i < indices.size(); i += 3) {
    TriangleIndices triangle;
    for (size_t k = 0; k < 3; ++k) {
      const auto [known, is_new] = numbers.emplace(indices[i + k], static_cast<uint32_t>(surface.positions.size()));
      if (is_new) surface.positions.push_back(mesh.positions[known->first]);
      triangle[k] = known->second;
    }
    surface.triangles.push_back(triangle);
    surface.source.push_back(triangle_at[indices[i]]);
  }
  return surface;
}

using Vector = std::array<double, 3>;

// Evenly over half a sphere, since lines have no sense (Fibonacci's spiral).
std::array<Vector, kDirections> directions() {
  std::array<Vector, kDirections> all;
  for (size_t i = 0; i < kDirections; ++i) {
    const double y = (static_cast<double>(i) + 0.5) / kDirections, radius = std::sqrt(1 - y * y);
    const double angle = static_cast<double>(i) * std::numbers::pi * (3 - std::sqrt(5.0));
    all[i] = {radius * std::cos(angle), y, radius * std::sin(angle)};
  }
  return all;
}

Vector place_of(const PreparedMesh& mesh, const DrawnSurface& surface, size_t t) {
  const auto& positions = surface.thinned ? mesh.positions : surface.positions;
  const auto& triangle = surface.thinned ? mesh.triangles[surface.source[t]] : surface.triangles[t];
  Vector place{};
  for (const uint32_t corner : triangle)
    for (size_t a = 0; a < 3; ++a) place[a] += double{positions[corner][a]} / 3;
  return place;
}

uint8_t byte(double part, double whole) {
  return whole > 0 ? static_cast<uint8_t>(std::lround(255 * part / whole)) : 0;
}

Cell cell_of(const LineCell& line, uint32_t level) {
  const uint32_t low = 8 - level;
  return {line.pair, level, line.s >> low, line.t >> low, line.u >> low, line.v >> low};
}

// The cells to be judged, each once, and which triangles ask for them.
struct Asked {
  std::vector<Cell> cells;
  std::vector<std::pair<uint32_t, uint32_t>> by;  // triangle, cell
  std::map<std::tuple<uint32_t, uint32_t, uint32_t, uint32_t, uint32_t>, uint32_t> known;

  void add(size_t triangle, const Cell& cell) {
    const auto [at, is_new] =
        known.emplace(std::tuple(cell.pair, cell.s, cell.t, cell.u, cell.v), static_cast<uint32_t>(cells.size()));
    if (is_new) cells.push_back(cell);
    by.emplace_back(static_cast<uint32_t>(triangle), at->second);
  }
};

}  // namespace

DrawnSurface drawn_surface(const PreparedMesh& mesh, size_t most_triangles) {
  if (mesh.triangles.size() > most_triangles) return thinned(mesh, most_triangles);
  DrawnSurface surface{mesh.positions, mesh.triangles, {}, false};
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) surface.source.push_back(t);
  while (4 * surface.triangles.size() <= std::min(most_triangles, kFineTriangles)) surface = cut(std::move(surface));
  return surface;
}

Result<SurfaceShares> surface_shares(const ObjectContents& object, const PreparedMesh& mesh,
                                     const DrawnSurface& surface, const std::function<bool()>& stop) {
  const size_t count = surface.triangles.size();
  const size_t judged = std::clamp<size_t>(kJudgedLines / std::max<size_t>(count, 1), 1, kDirections);
  const uint32_t level = object.record->depth;
  SurfaceShares shares;
  Asked asked;
  const auto spread = directions();
  for (size_t t = 0; t < count; ++t) {
    const Vector place = place_of(mesh, surface, t);
    size_t answered = 0, proven = 0, left = judged;
    for (size_t i = 0; i < kDirections; ++i) {
      const Vector& direction = spread[(i + 7 * t) % kDirections];  // each begins elsewhere
      const auto found = cell_of_line(object, place, direction);
      const CellClass cell = found ? found->cell : CellClass::unclassified;
      answered += cell != CellClass::unclassified;
      proven += cell == CellClass::blocked;
      if (found && cell == CellClass::unclassified && left > 0) --left, asked.add(t, cell_of(found->line, level));
    }
    shares.answered.push_back(byte(static_cast<double>(answered), kDirections));
    shares.proven.push_back(byte(static_cast<double>(proven), kDirections));
  }
  const auto whys = why_unclassified(mesh, asked.cells, stop);
  if (!whys) return whys.error();
  std::vector<std::array<uint32_t, kWhys>> counts(count);
  for (const auto& [triangle, cell] : asked.by) ++counts[triangle][static_cast<size_t>((*whys)[cell])];
  for (size_t w = 0; w < kWhys; ++w)
    for (const auto& of : counts) {
      uint32_t sum = 0;
      for (const uint32_t n : of) sum += n;
      shares.why[w].push_back(byte(of[w], sum));
    }
  return shares;
}

}  // namespace vcd::tools
