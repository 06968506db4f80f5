// Classification by proof: clear and blocked hold for every line of a cell, grown by the guard band.
#pragma once

#include <cstdint>

#include <vcd/baker/prepare.h>
#include <vcd/baker/sampled.h>
#include <vcd/baker/tracer.h>

#include "classify/cell_classifier.h"

namespace vcd {

struct ProvenOptions {
  uint64_t seed = 0;
  uint32_t statistical_samples = 0;  // 81 or 256: a second tier at the deepest level; 0: proofs only
};

class ProvenClassifier : public CellClassifier {
 public:
  // The tracer holds the mesh in grid units, and outlives this.
  ProvenClassifier(const PreparedMesh& mesh, const Tracer& tracer, const ProvenOptions& options);

  uint32_t classify(const Cell& cell, bool deepest, Workspace& workspace) const override;

 private:
  bool prove_clear(const Cell& cell, Workspace& workspace) const;
  bool prove_blocked(const Cell& cell, Workspace& workspace) const;
  bool statistically_blocked(const Cell& cell, Workspace& workspace) const;

  ProvenOptions options_;
  const Tracer& tracer_;
  size_t triangle_count_;
  SampledClassifier first_look_;
  SampledClassifier statistical_;
  TriangleGroups groups_;
  Surface surface_;
};

}  // namespace vcd
