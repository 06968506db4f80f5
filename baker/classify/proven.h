// Classification by proof: clear and blocked hold for every line of a cell, grown by the guard band.
#pragma once

#include <cstdint>

#include <vcd/baker/sampled.h>
#include <vcd/baker/tracer.h>

#include "classify/cell_classifier.h"
#include "prepare/grid_mesh.h"

namespace vcd::baker {

struct ProvenOptions {
  uint64_t seed = 0;
  bool statistical_tier = false;  // at the deepest level, where there is no proof
  uint32_t samples = 0;           // of a cell of that tier: 81 or 256; 0: 81 where rays_alone(), else 256
};

class ProvenClassifier : public CellClassifier {
 public:
  // mesh and its tracer outlive this.
  ProvenClassifier(const GridMesh& mesh, const Tracer& tracer, const ProvenOptions& options);

  uint32_t classify(const Cell& cell, bool deepest, Workspace& workspace) const override;

  // What becomes of a proof of blocked.
  struct Attempt {
    bool looks_blocked = false;  // to 16 rays; else no proof is tried
    bool is_proven = false;
    uint32_t ended_at = 0;  // a boundary edge at which a sheet ends: 3 · triangle + edge; kBoundary if none does
  };
  Attempt try_blocked(const Cell& cell, Workspace& workspace) const;

  // Whether proofs of blocked hardly ever succeed, as in foliage and hair, so that with a statistical tier none is
  // tried.
  bool rays_alone() const { return rays_alone_; }
  uint32_t samples() const { return samples_; }  // of the statistical tier

 private:
  bool proofs_fail() const;
  bool prove_clear(const Cell& cell, Workspace& workspace) const;
  bool prove_blocked(const Cell& cell, Workspace& workspace) const;
  bool statistically_blocked(const Cell& cell, Workspace& workspace) const;
  bool parent_blocked(const Cell& parent, Workspace& workspace) const;

  uint64_t seed_;
  bool statistical_tier_;
  const Tracer& tracer_;
  size_t triangle_count_;
  SampledClassifier first_look_;
  TriangleGroups groups_;
  Surface surface_;
  bool rays_alone_;
  uint32_t samples_;
  SampledClassifier statistical_, parent_rays_;
};

}  // namespace vcd::baker
