#include "classify/make_classifier.h"

#include <cassert>
#include <utility>

#include "classify/proven.h"
#include "classify/sampled_cells.h"
#include "prepare/place.h"

namespace vcd::baker {

Result<Tracer> trace_in_grid(const GridMesh& mesh) {
  auto tracer = Tracer::build(mesh.positions, mesh.triangles());
  if (!tracer) return Error{tracer.error().code, place_of(mesh.source) + ": " + tracer.error().message};
  return tracer;
}

ChosenClassifier make_classifier(const GridMesh& mesh, const Tracer& tracer, const BakeOptions& options) {
  assert(options.method != Method::none);
  if (options.method == Method::sampled) {
    const uint32_t samples = options.samples ? options.samples : kDefaultSamples;
    return {std::make_unique<SampledCells>(SampledClassifier(tracer, samples, options.seed)), nullptr, samples};
  }
  const ProvenOptions proven{options.seed, options.method == Method::hybrid, options.samples};
  auto classifier = std::make_unique<ProvenClassifier>(mesh, tracer, proven);
  const ProvenClassifier* const proofs = classifier.get();
  return {std::move(classifier), proofs, proofs->samples()};
}

}  // namespace vcd::baker
