#include <vcd/baker/audit.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <tbb/parallel_for.h>

#include "audit/lines.h"
#include <vcd/baker/tracer.h>

namespace vcd {
namespace {

constexpr uint64_t kBatch = 4096;  // segments that share a generator

struct Batch {
  AuditCounts counts;
  std::vector<Contradiction> contradictions;
};

// Embree loses hits on meshes of 1e-14 or 1e17 units. The mesh times a power of two is the same mesh, without rounding.
struct ScaledTracer {
  float scale;
  Tracer tracer;

  static Result<ScaledTracer> build(const PreparedMesh& mesh) {
    float largest = 0;
    for (int a = 0; a < 3; ++a) largest = std::max(largest, mesh.box_max[a] - mesh.box_min[a]);
    const float scale = std::ldexp(1.0f, -std::ilogb(largest));
    std::vector<Position> positions = mesh.positions;
    for (Position& p : positions)
      for (float& x : p) x *= scale;
    auto tracer = Tracer::build(positions, mesh.triangles);
    if (!tracer) return tracer.error();
    return ScaledTracer{scale, std::move(*tracer)};
  }
  bool occluded(Segment segment) const {
    for (int a = 0; a < 3; ++a) {
      segment.origin[a] *= scale;
      segment.direction[a] *= scale;
    }
    return tracer.occluded(segment);
  }
};

Batch run_batch(const PreparedMesh& mesh, const GridFrame& frame, const TreeView& tree, const ScaledTracer& tracer,
                AuditKind kind, uint64_t seed, uint64_t count) {
  Batch batch;
  AuditLines lines(mesh, kind, seed);
  for (uint64_t i = 0; i < count; ++i) {
    const Segment segment = lines.next();
    ++batch.counts.segments;
    const Visibility answer = classify(frame, tree, tree.shape, segment);
    if (answer == Visibility::unclassified) continue;
    const auto which = static_cast<size_t>(answer);
    ++batch.counts.answered[which];
    if (tracer.occluded(segment) == (answer == Visibility::blocked)) continue;
    ++batch.counts.wrong[which];
    batch.contradictions.push_back({kind, segment, answer});
  }
  return batch;
}

}  // namespace

const char* audit_kind_name(AuditKind kind) {
  constexpr const char* kNames[kAuditKinds] = {"uniform", "chords", "inside", "edges", "vertices"};
  return kNames[static_cast<size_t>(kind)];
}

Result<AuditReport> audit(const PreparedMesh& mesh, const ObjectRecord& record, const TreeView& tree,
                          const AuditOptions& options) {
  // Traced in the object's own frame, as a renderer would: the mapping to the grid is under test too.
  const auto tracer = ScaledTracer::build(mesh);
  if (!tracer) return tracer.error();
  const GridFrame frame = make_grid_frame(record.box_min, record.box_max);

  AuditReport report;
  for (size_t k = 0; k < kAuditKinds; ++k) {
    const auto kind = static_cast<AuditKind>(k);
    const bool whole = kind == AuditKind::uniform || kind == AuditKind::chords;
    const uint64_t lines = whole ? options.lines : options.lines / 2;
    std::vector<Batch> batches((lines + kBatch - 1) / kBatch);
    tbb::parallel_for(size_t{0}, batches.size(), [&](size_t b) {
      const uint64_t count = std::min(kBatch, lines - b * kBatch);
      batches[b] = run_batch(mesh, frame, tree, *tracer, kind, options.seed * 1000003 + b, count);
    });
    for (const Batch& batch : batches) {
      AuditCounts& total = report.counts[k];
      total.segments += batch.counts.segments;
      for (int c = 0; c < 2; ++c) {
        total.answered[c] += batch.counts.answered[c];
        total.wrong[c] += batch.counts.wrong[c];
      }
      for (const Contradiction& contradiction : batch.contradictions)
        if (report.contradictions.size() < options.keep) report.contradictions.push_back(contradiction);
    }
  }
  return report;
}

std::vector<Segment> audit_segments(const PreparedMesh& mesh, AuditKind kind, uint64_t seed, uint64_t count) {
  AuditLines lines(mesh, kind, seed);
  std::vector<Segment> segments(count);
  for (Segment& segment : segments) segment = lines.next();
  return segments;
}

Result<bool> trace_segment(const PreparedMesh& mesh, const Segment& segment) {
  const auto tracer = ScaledTracer::build(mesh);
  if (!tracer) return tracer.error();
  return tracer->occluded(segment);
}

double upper_bound_95(uint64_t wrong, uint64_t all) {
  if (all == 0) return 1;
  // The largest Poisson mean under which seeing `wrong` or fewer still has probability 5 %, by bisection.
  const auto probability_of_so_few = [&](double mean) {
    double sum = 0;
    for (uint64_t k = 0; k <= wrong; ++k)
      sum += std::exp(static_cast<double>(k) * std::log(mean) - mean - std::lgamma(static_cast<double>(k) + 1));
    return sum;
  };
  const double seen = static_cast<double>(wrong);
  double low = seen + 1e-9, high = seen + 10 + 5 * std::sqrt(seen + 1);
  for (int i = 0; i < 60; ++i) (probability_of_so_few((low + high) / 2) > 0.05 ? low : high) = (low + high) / 2;
  return std::min(1.0, high / static_cast<double>(all));
}

}  // namespace vcd
