// What ingest() and prepare() promise of their results, checked without their own code.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <vcd/baker/ingest.h>
#include <vcd/baker/prepare.h>

#include "fuzz/fuzz.h"

namespace vcd::fuzz {

inline bool finite(const baker::Position& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

inline void require_indices_in_range(const std::vector<baker::TriangleIndices>& triangles, size_t positions) {
  for (const baker::TriangleIndices& t : triangles)
    for (const uint32_t corner : t) require(corner < positions, "indices are in range");
}

inline void require_ingested(const baker::Ingested& ingested) {
  require(!ingested.meshes.empty(), "there is a mesh");
  for (const baker::SourceMesh& mesh : ingested.meshes) {
    require(!mesh.triangles.empty(), "each mesh has a triangle");
    require(std::ranges::all_of(mesh.positions, finite), "positions are finite");
    require_indices_in_range(mesh.triangles, mesh.positions.size());
  }
  for (const baker::Placement& placement : ingested.placements) {
    require(placement.mesh < ingested.meshes.size(), "a placement is of a mesh that is there");
    require(std::ranges::all_of(placement.transform, [](double x) { return std::isfinite(static_cast<float>(x)); }),
            "placements are finite");
  }
}

// The header of prepare.h, sentence by sentence.
inline void require_prepared(const baker::PreparedMesh& mesh) {
  require(!mesh.triangles.empty(), "a prepared mesh has a triangle");
  require(std::ranges::adjacent_find(mesh.positions, std::greater_equal()) == mesh.positions.end(),
          "positions are sorted and unique");
  require_indices_in_range(mesh.triangles, mesh.positions.size());
  std::vector<bool> used(mesh.positions.size());
  std::vector<baker::TriangleIndices> ascending = mesh.triangles;
  for (baker::TriangleIndices& t : ascending) {
    require(t[0] < t[1] && t[0] < t[2] && t[1] != t[2], "the smallest index comes first, and corners differ");
    for (const uint32_t corner : t) used[corner] = true;
    std::ranges::sort(t);
  }
  require(std::ranges::find(used, false) == used.end(), "every position is used");
  require(std::ranges::adjacent_find(ascending, std::greater_equal()) == ascending.end(),
          "triangles are sorted and unique");
  for (const baker::Position& p : mesh.positions)
    for (size_t a = 0; a < 3; ++a) {
      require(!(p[a] == 0 && std::signbit(p[a])), "there is no -0");
      const double margin = 4 * 0x1p-13 * (double{mesh.box_max[a]} - double{mesh.box_min[a]});
      require(p[a] - double{mesh.box_min[a]} >= margin && double{mesh.box_max[a]} - p[a] >= margin,
              "the box holds every vertex with its margin (vcd-format.md, \"Box\")");
    }
}

// Prepares a mesh, and the result once more, which must change nothing.
inline void require_prepare_holds(baker::SourceMesh mesh) {
  Result<baker::PreparedMesh> once = baker::prepare(std::move(mesh));
  if (!once) {
    require(once.error().code == ErrorCode::invalid_file || once.error().code == ErrorCode::unsupported,
            "baker::prepare() fails with invalid_file or unsupported");
    return;
  }
  require_prepared(*once);
  const Result<baker::PreparedMesh> twice = baker::prepare({"", 0, once->positions, once->triangles});
  require(twice.ok() && twice->duplicate_triangles == 0 && twice->zero_area_triangles == 0,
          "a prepared mesh can be prepared again");
  require(twice->positions == once->positions && twice->triangles == once->triangles &&
              twice->box_min == once->box_min && twice->box_max == once->box_max &&
              twice->geometry_hash == once->geometry_hash,
          "preparing a prepared mesh changes nothing");
}

}  // namespace vcd::fuzz
