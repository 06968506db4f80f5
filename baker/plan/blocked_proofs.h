// What the boundary edges of a mesh cost in proofs, counted.
#pragma once

#include <vcd/baker/mesh_health.h>
#include <vcd/baker/plan.h>
#include <vcd/baker/prepare.h>

#include "classify/proven.h"

namespace vcd::baker {

// Tries proofs in up to 1000 cells of the level that look blocked, among at most 10,000 chosen evenly. Depends on mesh
// and classifier alone.
BlockedProofs count_blocked_proofs(const ProvenClassifier& classifier, const PreparedMesh& mesh,
                                   const MeshHealth& health, uint32_t level);

}  // namespace vcd::baker
