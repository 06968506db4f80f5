#include "blocked_proofs.h"

#include <algorithm>
#include <random>

#include <vcd/format/line_cell.h>

#include "prepare/topology.h"

namespace vcd::baker {

BlockedProofs count_blocked_proofs(const ProvenClassifier& classifier, const PreparedMesh& mesh,
                                   const MeshHealth& health, uint32_t level) {
  constexpr uint32_t kMostCells = 10'000, kMostTried = 1000;
  BlockedProofs counts{.level = level};
  Workspace workspace;
  std::mt19937_64 random(level);
  const auto coordinate = [&] { return static_cast<uint32_t>(random() >> (64 - level)); };
  for (; counts.cells < kMostCells && counts.look_blocked < kMostTried; ++counts.cells) {
    Cell cell{counts.cells % kFacePairs, level, 0, 0, 0, 0};
    for (uint32_t* c : {&cell.s, &cell.t, &cell.u, &cell.v}) *c = coordinate();
    const auto attempt = classifier.try_blocked(cell, workspace);
    counts.look_blocked += attempt.looks_blocked;
    counts.proven += attempt.is_proven;
    if (!attempt.looks_blocked || attempt.is_proven || attempt.ended_at == kBoundary) continue;
    const TriangleIndices& t = mesh.triangles[attempt.ended_at / 3];
    const uint32_t a = t[attempt.ended_at % 3], b = t[(attempt.ended_at % 3 + 1) % 3];
    const bool is_boundary =
        std::ranges::binary_search(health.boundary_edges, MeshHealth::Edge{std::min(a, b), std::max(a, b)});
    ++(is_boundary ? counts.at_boundary : counts.at_nonmanifold);
  }
  return counts;
}

}  // namespace vcd::baker
