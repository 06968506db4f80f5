// The probe: random paths down the octree, classified as a bake would.
#pragma once

#include <functional>

#include <vcd/baker/plan.h>
#include <vcd/baker/prepare.h>
#include <vcd/baker/tracer.h>

#include "classify/cell_classifier.h"

namespace vcd::baker {

struct ProbeOptions {
  unsigned threads;       // of the bake that is forecast
  uint64_t budget_bytes;  // of the tree
  double budget_seconds;  // of the bake; infinity for none
  uint32_t deepest = 7;   // depth to forecast
  std::function<bool()> stop = {};
};

// Forecasts each depth and picks one. But for `seconds` and `gain` everything depends on mesh and classifier alone, and
// so does the choice unless a budget of seconds decides.
//
// The rule: as deep as still resolves two more in a hundred shadow-like segments than the level above, while the bytes
// stay within twice the budget (demote-merge takes the rest) and the seconds within the budget. Not at all: meshes of
// fewer than kLeastTriangles triangles, whose hierarchy is as fast as a look-up, and those of which it would resolve
// less than kLeastResolved.
Plan probe(const PreparedMesh& mesh, const Tracer& tracer, const CellClassifier& classifier,
           const ProbeOptions& options);

inline constexpr uint64_t kLeastTriangles = 64;
inline constexpr double kLeastResolved = 0.1;

}  // namespace vcd::baker
