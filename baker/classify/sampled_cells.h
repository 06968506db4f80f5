// The paper's classification as the recursion asks for it.
#pragma once

#include <vcd/baker/sampled.h>

#include "classify/cell_classifier.h"

namespace vcd::baker {

class SampledCells : public CellClassifier {
 public:
  explicit SampledCells(const SampledClassifier& classifier) : classifier_(classifier) {}

  uint32_t classify(const Cell& cell, bool deepest, Workspace& workspace) const override {
    switch (classifier_.classify(cell, workspace.rays)) {
      case CellVerdict::clear: return kClear;
      case CellVerdict::blocked: return kBlocked;
      default: return deepest ? kUnclassified : kDeeper;
    }
  }

 private:
  SampledClassifier classifier_;
};

}  // namespace vcd::baker
