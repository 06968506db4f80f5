#include <vcd/baker/why_unclassified.h>

#include <atomic>
#include <bit>
#include <new>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <vcd/format/line_cell.h>

#include "classify/make_classifier.h"
#include "classify/proven.h"
#include "prepare/place.h"
#include "prepare/topology.h"

namespace vcd::baker {
namespace {

constexpr uint32_t kDiagonals = 8, kSteps = 8;

// The point of a face where its two coordinates are `first` and `second` steps of a cell's width.
void place_on(uint32_t face, float first, float second, float (&point)[3]) {
  const FaceAxes axes = face_axes(face);
  point[axes.normal] = face % 2 ? kGrid : 0.0f;
  point[axes.first] = first, point[axes.second] = second;
}

// Bit k of the result: ray k of a diagonal is blocked. Bits 0 to 2 of `diagonal` say in which of t, u, v it descends.
uint32_t blocked_along(const Tracer& tracer, const Cell& cell, uint32_t diagonal) {
  const float width = kGrid / static_cast<float>(1u << cell.level);
  RTCRay16 rays{};
  for (uint32_t k = 0; k < kSteps; ++k) {
    const float step = (static_cast<float>(k) + 0.5f) / kSteps;
    const auto at = [&](uint32_t coordinate, bool descends) {
      return (static_cast<float>(coordinate) + (descends ? 1 - step : step)) * width;
    };
    float from[3], to[3];
    place_on(kFacePair[cell.pair].low, at(cell.s, false), at(cell.t, diagonal & 1), from);
    place_on(kFacePair[cell.pair].high, at(cell.u, diagonal & 2), at(cell.v, diagonal & 4), to);
    rays.org_x[k] = from[0], rays.org_y[k] = from[1], rays.org_z[k] = from[2];
    rays.dir_x[k] = to[0] - from[0], rays.dir_y[k] = to[1] - from[1], rays.dir_z[k] = to[2] - from[2];
    rays.tfar[k] = 1;
    rays.mask[k] = 0xFFFFFFFF;
  }
  return tracer.occluded(rays, kSteps, true);
}

bool changes_often(const Tracer& tracer, const Cell& cell) {
  for (uint32_t diagonal = 0; diagonal < kDiagonals; ++diagonal) {
    const uint32_t blocked = blocked_along(tracer, cell, diagonal);
    if (std::popcount((blocked ^ blocked >> 1) & ((1u << (kSteps - 1)) - 1)) > 1) return true;
  }
  return false;
}

Why why(const ProvenClassifier& proofs, const Tracer& tracer, const Cell& cell, Workspace& workspace) {
  const auto attempt = proofs.try_blocked(cell, workspace);
  if (!attempt.looks_blocked) return changes_often(tracer, cell) ? Why::foliage : Why::silhouette;
  if (attempt.is_proven) return Why::known;
  return attempt.ended_at == kBoundary ? Why::unproven : Why::boundary;
}

}  // namespace

Result<std::vector<Why>> why_unclassified(const PreparedMesh& mesh, std::span<const Cell> cells,
                                          const std::function<bool()>& stop) try {
  const GridMesh grid(mesh);
  const auto tracer = trace_in_grid(grid);
  if (!tracer) return tracer.error();
  const ProvenClassifier proofs(grid, *tracer, {});
  std::vector<Why> whys(cells.size());
  tbb::enumerable_thread_specific<Workspace> workspaces;
  std::atomic<bool> stopped = false;
  tbb::parallel_for(size_t{0}, cells.size(), [&](size_t i) {
    if (stopped || (stop && stop())) stopped = true;
    else whys[i] = why(proofs, *tracer, cells[i], workspaces.local());
  });
  if (stopped) return Error{ErrorCode::runtime, place_of(mesh) + ": stopped"};
  return whys;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, place_of(mesh) + ": out of memory"};
}

}  // namespace vcd::baker
