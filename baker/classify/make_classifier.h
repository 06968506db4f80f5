// From a mesh to what decides its cells' classes.
#pragma once

#include <cstdint>
#include <memory>

#include <vcd/baker/bake.h>
#include <vcd/baker/tracer.h>
#include <vcd/format/error.h>

#include "classify/cell_classifier.h"
#include "prepare/grid_mesh.h"

namespace vcd::baker {

// Embree's hierarchy over the mesh. Errors: runtime (out of memory).
Result<Tracer> trace_in_grid(const GridMesh& mesh);

class ProvenClassifier;

struct ChosenClassifier {
  std::unique_ptr<const CellClassifier> cells;
  const ProvenClassifier* proofs;  // the same, if it proves
  uint32_t samples;                // that a class by statistics rests on
};

// The classifier of options.method, which must not be none. Mesh and tracer outlive it.
ChosenClassifier make_classifier(const GridMesh& mesh, const Tracer& tracer, const BakeOptions& options);

inline constexpr uint32_t kDefaultSamples = 256;

}  // namespace vcd::baker
