// A mesh, its hierarchy, and exact arithmetic to judge what is said of them.
#pragma once

#include <algorithm>

#include <vcd/baker/hierarchy.h>
#include <vcd/baker/prepare.h>
#include <vcd/baker/referee.h>

#include "hierarchy/traced.h"
#include "support/files.h"
#include "support/random.h"

namespace vcd::test {

inline constexpr int kShare = kSanitized ? 6 : 1;  // what sanitizers take of each test's segments

// A mesh with its hierarchy and its judge.
struct JudgedMesh {
  baker::PreparedMesh mesh;
  baker::HierarchySection section;
  Traced traced;
  baker::Referee referee;

  explicit JudgedMesh(baker::SourceMesh source)
      : mesh(*baker::prepare(std::move(source))),
        section(*baker::build_hierarchy(mesh)),
        traced(vcd::traced(baker::view_of(section))),
        referee(mesh) {}

  float extent() const {
    float longest = 0;
    for (size_t a = 0; a < 3; ++a) longest = std::max(longest, mesh.box_max[a] - mesh.box_min[a]);
    return longest;
  }
  baker::Position between(FloatRandom& random, float grow) const {
    baker::Position p;
    for (size_t a = 0; a < 3; ++a) {
      const float room = grow * (mesh.box_max[a] - mesh.box_min[a]);
      p[a] = random.between(mesh.box_min[a] - room, mesh.box_max[a] + room);
    }
    return p;
  }
  baker::Position on_surface(FloatRandom& random) const {
    const baker::TriangleIndices& t = mesh.triangles[random.below(static_cast<uint32_t>(mesh.triangles.size()))];
    const float u = random.uniform(), v = random.uniform() * (1 - u);
    baker::Position p;
    for (size_t a = 0; a < 3; ++a) {
      const float corner = mesh.positions[t[0]][a];
      p[a] = corner + u * (mesh.positions[t[1]][a] - corner) + v * (mesh.positions[t[2]][a] - corner);
    }
    return p;
  }
};

}  // namespace vcd::test
