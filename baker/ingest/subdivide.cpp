#include "ingest/subdivide.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/LoopT.hh>

#include "ingest/check.h"
#include "prepare/topology.h"

namespace vcd::baker {
namespace {

// LoopT computes in the type of normals, too.
struct InDoubles : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using HalfEdges = OpenMesh::TriMesh_ArrayKernelT<InDoubles>;

// Of weights alone. As doubles they would show in which library the cosine was made; see subdivide.h.
using Weight = float;

// OpenMesh numbers half-edges, up to six a triangle, by int.
constexpr uint64_t kMostTriangles = uint64_t{1} << 28;
// What OpenMesh, the subdivider and the result take about, while arrays grow.
constexpr uint64_t kBytesPerTriangle = 240;

struct ControlMesh {
  std::vector<Position> positions;         // unique, sorted
  std::vector<TriangleIndices> triangles;  // wound as they were, sorted
  size_t passed_over = 0;
};

ControlMesh weld_wound(const SourceMesh& source) {
  ControlMesh mesh;
  mesh.positions = source.positions;
  for (Position& p : mesh.positions)
    for (float& x : p) x += 0.0f;  // -0 becomes +0
  const std::vector<Position> given = mesh.positions;
  std::ranges::sort(mesh.positions);
  mesh.positions.erase(std::ranges::unique(mesh.positions).begin(), mesh.positions.end());

  const auto corners_of = [](TriangleIndices t) { return std::ranges::sort(t), t; };
  for (TriangleIndices t : source.triangles) {
    for (uint32_t& corner : t)
      corner = static_cast<uint32_t>(std::ranges::lower_bound(mesh.positions, given[corner]) - mesh.positions.begin());
    std::ranges::rotate(t, std::ranges::min_element(t));
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles.push_back(t);
  }
  std::ranges::sort(mesh.triangles, [&](const TriangleIndices& a, const TriangleIndices& b) {
    return std::pair(corners_of(a), a) < std::pair(corners_of(b), b);
  });
  const auto [first, last] = std::ranges::unique(mesh.triangles, {}, corners_of);
  mesh.triangles.erase(first, last);
  mesh.passed_over = source.triangles.size() - mesh.triangles.size();
  return mesh;
}

std::string text_of(const Position& p) {
  char text[64];
  std::snprintf(text, sizeof text, "(%.9g, %.9g, %.9g)", static_cast<double>(p[0]), static_cast<double>(p[1]),
                static_cast<double>(p[2]));
  return text;
}

// The first edge of three triangles or more, if there is one.
std::optional<EdgeSide> find_complex(std::span<const EdgeSide> sides) {
  for (size_t i = 2; i < sides.size(); ++i)
    if (sides[i].low == sides[i - 2].low && sides[i].high == sides[i - 2].high) return sides[i];
  return std::nullopt;
}

// Gives each fan of triangles a vertex of its own, as OpenMesh advises. Returns how many came of that.
size_t split_vertices(ControlMesh& mesh, std::span<const EdgeSide> sides) {
  const std::vector<uint32_t> fans = corner_fans(mesh.triangles, sides);
  std::vector<uint32_t> vertex_of(fans.size());
  std::vector<Position> positions;
  std::vector<bool> has_one(mesh.positions.size());
  size_t split = 0;
  for (uint32_t corner = 0; corner < fans.size(); ++corner) {
    uint32_t& vertex = mesh.triangles[corner / 3][corner % 3];
    if (fans[corner] == corner) {
      split += has_one[vertex];
      has_one[vertex] = true;
      vertex_of[corner] = static_cast<uint32_t>(positions.size());
      positions.push_back(mesh.positions[vertex]);
    }
    vertex = vertex_of[fans[corner]];
  }
  mesh.positions = std::move(positions);
  return split;
}

bool runs_along(const TriangleIndices& t, uint32_t from, uint32_t to) {
  return (t[0] == from && t[1] == to) || (t[1] == from && t[2] == to) || (t[2] == from && t[0] == to);
}

// Winds each piece as its first triangle is. Returns a triangle of a piece that has one side only, if there is one.
std::optional<TriangleIndices> wind_alike(ControlMesh& mesh) {
  const std::vector<uint32_t> neighbour = pair_edges(mesh.positions, mesh.triangles);
  std::vector<bool> reached(mesh.triangles.size()), turned(mesh.triangles.size());
  std::vector<uint32_t> stack;
  for (uint32_t seed = 0; seed < mesh.triangles.size(); ++seed) {
    if (!reached[seed]) reached[seed] = true, stack.push_back(seed);
    while (!stack.empty()) {
      const uint32_t t = stack.back();
      stack.pop_back();
      for (uint32_t i = 0; i < 3; ++i) {
        const uint32_t other = neighbour[3 * size_t{t} + i];
        if (other == kBoundary) continue;
        const bool is_against = runs_along(mesh.triangles[other], mesh.triangles[t][i], mesh.triangles[t][(i + 1) % 3]);
        const bool turn = turned[t] != is_against;
        if (reached[other] && turned[other] != turn) return mesh.triangles[other];
        if (!reached[other]) reached[other] = true, turned[other] = turn, stack.push_back(other);
      }
    }
  }
  for (size_t t = 0; t < turned.size(); ++t)
    if (turned[t]) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  return std::nullopt;
}

HalfEdges half_edges_of(const ControlMesh& mesh) {
  HalfEdges half_edges;
  std::vector<HalfEdges::VertexHandle> vertices;
  for (const Position& p : mesh.positions) vertices.push_back(half_edges.add_vertex({p[0], p[1], p[2]}));
  for (const TriangleIndices& t : mesh.triangles) half_edges.add_face(vertices[t[0]], vertices[t[1]], vertices[t[2]]);
  return half_edges;
}

void apply_loop(HalfEdges& half_edges, uint32_t times) {
  size_t valence = 0;
  for (const auto vertex : half_edges.vertices()) valence = std::max<size_t>(valence, half_edges.valence(vertex));
  OpenMesh::Subdivider::Uniform::LoopT<HalfEdges, Weight> loop;
  loop.init_weights(valence + 1);  // it has some for valences up to 49, and looks at no bound
  loop(half_edges, times);
}

void take(const HalfEdges& half_edges, SourceMesh& mesh) {
  mesh.positions.clear();
  mesh.triangles.clear();
  for (const auto vertex : half_edges.vertices()) {
    const OpenMesh::Vec3d& p = half_edges.point(vertex);
    mesh.positions.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
  }
  for (const auto face : half_edges.faces()) {
    TriangleIndices& triangle = mesh.triangles.emplace_back();
    std::ranges::transform(half_edges.fv_range(face), triangle.begin(),
                           [](const auto& vertex) { return static_cast<uint32_t>(vertex.idx()); });
  }
}

// Before memory is used.
std::optional<Error> check_size(uint64_t triangles, uint32_t times) {
  const uint64_t result = triangles << (2 * times);
  const std::string what =
      "its " + std::to_string(triangles) + " triangles would become " + std::to_string(result) + ", ";
  if (result > kMostTriangles)
    return Error{ErrorCode::unsupported, what + "more than " + std::to_string(kMostTriangles)};
  rlimit limit{};
  if (::getrlimit(RLIMIT_DATA, &limit) == 0 && limit.rlim_cur / kBytesPerTriangle < result)
    return Error{ErrorCode::runtime, what + "which takes about " + std::to_string(result * kBytesPerTriangle >> 20) +
                                         " MiB; the parser may take " + std::to_string(limit.rlim_cur >> 20)};
  return std::nullopt;
}

std::optional<Error> subdivide(SourceMesh& source, uint32_t times, std::vector<std::string>& notes,
                               const std::string& place) {
  if (auto too_large = check_size(source.triangles.size(), times)) return too_large;
  ControlMesh mesh = weld_wound(source);
  if (mesh.triangles.empty()) return std::nullopt;  // prepare() will say that it has no area
  const std::vector<EdgeSide> sides = edge_sides(mesh.triangles);
  if (const auto edge = find_complex(sides))
    return Error{ErrorCode::unsupported, "more than two triangles share the edge from " +
                                             text_of(mesh.positions[edge->low]) + " to " +
                                             text_of(mesh.positions[edge->high])};
  const size_t split = split_vertices(mesh, sides);
  if (const auto triangle = wind_alike(mesh))
    return Error{ErrorCode::unsupported, "the piece with a triangle at " + text_of(mesh.positions[(*triangle)[0]]) +
                                             " has one side only, as a Möbius strip has"};
  if (mesh.passed_over > 0)
    notes.push_back(place + ": " + std::to_string(mesh.passed_over) +
                    " triangles with equal corners, or with the corners of another one, were passed over before the "
                    "subdivision");
  if (split > 0)
    notes.push_back(place +
                    ": where triangles touched in a point without an edge there, they were taken apart before the "
                    "subdivision, at " +
                    std::to_string(split) + " points");
  HalfEdges half_edges = half_edges_of(mesh);
  mesh = {};
  apply_loop(half_edges, times);
  take(half_edges, source);
  return std::nullopt;
}

}  // namespace

std::optional<Error> subdivide(const std::filesystem::path& path, uint32_t times, Ingested& ingested) {
  if (times > kMostSubdivisions)
    return file_error(
        path, ErrorCode::usage,
        "to be subdivided " + std::to_string(times) + " times: more than " + std::to_string(kMostSubdivisions));
  for (SourceMesh& mesh : ingested.meshes) {
    const std::string place = "mesh " + std::to_string(mesh.source_index) + " \"" + mesh.name + "\"";
    if (auto fault = subdivide(mesh, times, ingested.notes, place))
      return file_error(path, fault->code, place + " cannot be subdivided: " + fault->message);
  }
  return std::nullopt;
}

}  // namespace vcd::baker
