// What of a mesh is no closed surface, as text, JSON and OBJ.
#pragma once

#include <string>

#include <vcd/baker/mesh_health.h>
#include <vcd/baker/plan.h>
#include <vcd/baker/prepare.h>

#include "describe.h"

namespace vcd::tools {

Json describe_health(const baker::MeshHealth& health);
Json describe_proofs(const baker::BlockedProofs& proofs);
std::string health_summary(const baker::MeshHealth& health);     // a line, indented by two spaces
std::string proofs_summary(const baker::BlockedProofs& proofs);  // likewise, two lines

// Boundary and non-manifold edges as lines and non-manifold vertices as points, in groups of an object each: a part of
// an OBJ file. before: vertices that the file has so far; those of this part are added.
std::string culprits_as_obj(const baker::PreparedMesh& mesh, const baker::MeshHealth& health, uint64_t& before);
inline constexpr std::string_view kCulpritsBegin = "# Culprits of vc-info: ";

}  // namespace vcd::tools
