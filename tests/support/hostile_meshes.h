// Small meshes that a proof could get wrong.
#pragma once

#include <vcd/baker/prepare.h>

#include "support/meshes.h"

namespace vcd::test {

inline void append(baker::SourceMesh& mesh, const baker::SourceMesh& more, float scale = 1,
                   baker::Position shift = {0, 0, 0}) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (const baker::Position& p : more.positions)
    mesh.positions.push_back({p[0] * scale + shift[0], p[1] * scale + shift[1], p[2] * scale + shift[2]});
  for (const baker::TriangleIndices& t : more.triangles)
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

inline baker::SourceMesh inverted(baker::SourceMesh mesh) {
  for (baker::TriangleIndices& t : mesh.triangles) std::swap(t[0], t[1]);
  return mesh;
}

// Without its triangle number `hole`.
inline baker::SourceMesh pierced(baker::SourceMesh mesh, size_t hole) {
  mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(hole));
  return mesh;
}

// A grid of quads, n × m, over a function of (i, j) in [0, 1]^2.
template <class Function>
baker::SourceMesh sheet(uint32_t n, uint32_t m, const Function& at) {
  baker::SourceMesh mesh{"sheet", 0, {}, {}};
  for (uint32_t i = 0; i <= n; ++i)
    for (uint32_t j = 0; j <= m; ++j)
      mesh.positions.push_back(
          at(static_cast<float>(i) / static_cast<float>(n), static_cast<float>(j) / static_cast<float>(m)));
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = 0; j < m; ++j) {
      const uint32_t a = i * (m + 1) + j, b = a + m + 1;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({b, b + 1, a + 1});
    }
  return mesh;
}

inline baker::SourceMesh flat(uint32_t n = 8) {
  return sheet(n, n, [](float x, float y) { return baker::Position{x, y, 0.25f}; });
}
// A sheet folded like a Z: lines cross it once or three times.
inline baker::SourceMesh folded() {
  return sheet(24, 6, [](float x, float y) {
    const float fold = x < 0.4f ? x : x < 0.6f ? 0.8f - x : x - 0.4f;
    return baker::Position{fold, y, 0.15f * x};
  });
}
// An open half of a sphere.
inline baker::SourceMesh hemisphere() {
  baker::SourceMesh mesh = sphere(24, 32);
  std::erase_if(mesh.triangles, [&](const baker::TriangleIndices& t) {
    return mesh.positions[t[0]][1] + mesh.positions[t[1]][1] + mesh.positions[t[2]][1] < 0;
  });
  return mesh;
}
inline baker::SourceMesh moebius(uint32_t segments = 24) {
  baker::SourceMesh mesh{"moebius", 0, {}, {}};
  for (uint32_t s = 0; s < segments; ++s)
    for (int side = -1; side <= 1; side += 2) {
      const double phi = 2 * std::numbers::pi * s / segments, r = 1 + 0.5 * side * std::cos(phi / 2);
      mesh.positions.push_back({static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
                                static_cast<float>(0.5 * side * std::sin(phi / 2))});
    }
  for (uint32_t s = 0; s < segments; ++s) {
    const bool last = s + 1 == segments;  // the strip closes with a half turn
    const uint32_t a = 2 * s, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({b, c, d});
  }
  return mesh;
}
// Three spheres through each other.
inline baker::SourceMesh intersecting() {
  baker::SourceMesh mesh = sphere(12, 16);
  append(mesh, sphere(11, 17), 0.9f, {0.7f, 0.1f, 0.2f});
  append(mesh, inverted(sphere(9, 13)), 0.6f, {0.3f, -0.5f, 0.4f});
  return mesh;
}
// A wall whose two halves do not share the vertices along the seam, and leave hair-fine gaps there.
inline baker::SourceMesh t_junctions() {
  baker::SourceMesh mesh = sheet(4, 8, [](float x, float y) { return baker::Position{x, y, 0.1f * y * y}; });
  append(mesh, sheet(4, 5, [](float x, float y) { return baker::Position{x + 1, y, 0.1f * y * y}; }));
  return mesh;
}
// Strips a million times as long as wide, side by side, and one gap.
inline baker::SourceMesh slivers() {
  baker::SourceMesh mesh{"slivers", 0, {}, {}};
  for (uint32_t i = 0; i < 40; ++i) {
    const float y = static_cast<float>(i) * 1e-6f + (i > 20 ? 0.3f : 0);
    mesh.positions.push_back({0, y, 0});
    mesh.positions.push_back({1, y, 0.4f});
    if (i > 0) {
      const uint32_t a = 2 * i;
      mesh.triangles.push_back({a - 2, a - 1, a});
      mesh.triangles.push_back({a - 1, a + 1, a});
    }
  }
  append(mesh, cube(), 0.2f, {0.4f, 0.05f, 0.3f});
  return mesh;
}
// Faces in one plane over each other, cut into triangles in different ways.
inline baker::SourceMesh coplanar() {
  baker::SourceMesh mesh = sheet(3, 3, [](float x, float y) { return baker::Position{x, y, x * 0.5f}; });
  append(mesh, sheet(4, 4, [](float x, float y) { return baker::Position{x + 0.25f, y, x * 0.5f + 0.125f}; }));
  return mesh;
}
inline baker::SourceMesh twice() {
  baker::SourceMesh mesh = sphere(10, 14);
  append(mesh, inverted(sphere(10, 14)));             // the same triangles, turned over
  append(mesh, sphere(10, 14), 1, {0x1p-20f, 0, 0});  // and once more, a hair beside
  return mesh;
}
inline baker::SourceMesh many_components() {
  baker::SourceMesh mesh{"components", 0, {}, {}};
  std::mt19937 random(5);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  for (int i = 0; i < 40; ++i) append(mesh, cube(), 0.05f + 0.3f * uniform(), {uniform(), uniform(), uniform()});
  return mesh;
}
inline baker::SourceMesh box_in_a_box() {
  baker::SourceMesh mesh = cube();
  append(mesh, inverted(cube()), 0.5f, {0.25f, 0.25f, 0.25f});
  return mesh;
}
// Three and more faces at the edges: a cube with a wall inside, and fins.
inline baker::SourceMesh fins() {
  baker::SourceMesh mesh = cube();
  mesh.triangles.push_back({0, 3, 7});
  mesh.triangles.push_back({0, 7, 4});
  for (float z : {-0.5f, 0.2f, 1.5f}) {
    mesh.positions.push_back({1.5f, 0.5f, z});
    mesh.triangles.push_back({1, 3, static_cast<uint32_t>(mesh.positions.size() - 1)});
  }
  return mesh;
}
// A thousand triangles round one vertex, and a thousand at one edge.
inline baker::SourceMesh fans() {
  baker::SourceMesh mesh{"fans", 0, {{0, 0, 0.3f}, {0, 0, 0.5f}}, {}};
  for (uint32_t i = 0; i < 1000; ++i) {
    const double phi = 2 * std::numbers::pi * i / 1000;
    mesh.positions.push_back({static_cast<float>(std::cos(phi)), static_cast<float>(std::sin(phi)), 0});
  }
  for (uint32_t i = 0; i < 1000; ++i) {
    mesh.triangles.push_back({0, 2 + i, 2 + (i + 1) % 1000});
    if (i % 3 == 0) mesh.triangles.push_back({0, 1, 2 + i});
  }
  return mesh;
}
// Two tetrahedra that touch at one vertex.
inline baker::SourceMesh bow_tie() {
  baker::SourceMesh mesh{
      "bow tie", 0, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}, {}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}, {0, 4, 5}, {0, 6, 4}, {0, 5, 6}, {4, 6, 5}};
  return mesh;
}

// A mesh whose grid units are its own unit: positions of a source mesh, mapped into [16, 240] and rounded to multiples
// of `step`, so that mirroring and exchanging axes is exact, and vertices can lie on the boundaries of cells.
inline baker::SourceMesh on_grid(baker::SourceMesh mesh, float step) {
  baker::Position low = mesh.positions[0], high = low;
  for (const baker::Position& p : mesh.positions)
    for (size_t a = 0; a < 3; ++a) low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
  float extent = 0;
  for (size_t a = 0; a < 3; ++a) extent = std::max(extent, high[a] - low[a]);
  for (baker::Position& p : mesh.positions)
    for (size_t a = 0; a < 3; ++a) p[a] = 16 + std::round((p[a] - low[a]) / extent * 224 / step) * step;
  return mesh;
}
inline baker::PreparedMesh prepared_on_grid(baker::SourceMesh mesh) {
  baker::PreparedMesh prepared = *baker::prepare(std::move(mesh));
  prepared.box_min = {0, 0, 0};
  prepared.box_max = {256, 256, 256};
  return prepared;
}

inline std::vector<baker::PreparedMesh> hostile_meshes() {
  std::vector<baker::PreparedMesh> meshes;
  for (baker::SourceMesh mesh : {cube(),
                                 sphere(),
                                 triangle(),
                                 leaves(40),
                                 flat(),
                                 folded(),
                                 hemisphere(),
                                 moebius(),
                                 inverted(sphere(12, 20)),
                                 intersecting(),
                                 t_junctions(),
                                 slivers(),
                                 coplanar(),
                                 twice(),
                                 many_components(),
                                 box_in_a_box(),
                                 fins(),
                                 fans(),
                                 bow_tie(),
                                 pierced(sphere(), 800),
                                 pierced(sphere(12, 20), 200),
                                 leaves(2000)})
    meshes.push_back(*baker::prepare(std::move(mesh)));
  for (const auto& mesh : {cube(), sphere(8, 12), fins(), box_in_a_box(), leaves(30), many_components()})
    meshes.push_back(prepared_on_grid(on_grid(mesh, 16)));  // vertices on the boundaries of cells of level 4
  return meshes;
}

}  // namespace vcd::test
