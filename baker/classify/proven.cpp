#include "proven.h"

#include <algorithm>
#include <array>

#include "prepare/topology.h"

namespace vcd {
namespace {

// Sheets of more triangles are given up: deeper cells see less of them.
constexpr uint32_t kFloodLimit = 2000;
// Sheets that are tried before a cell is given up.
constexpr size_t kMostSheets = 8;

// Lines through a cell at the same place in both squares, one after the other until one passes no edge too closely.
constexpr std::array<std::array<double, 4>, 3> kPlaces = {{{0.5, 0.5, 0.5, 0.5}, {0.4375, 0.5625, 0.578125, 0.453125}, {0.578125, 0.4375, 0.484375, 0.609375}}};

Line line_through(const Cell& cell, const std::array<double, 4>& place) {
  const auto [low, high] = squares(cell);
  const auto at = [](const Square& s, double first, double second) {
    std::array<double, 3> p = s.min;
    int coordinate = 0;
    for (size_t a = 0; a < 3; ++a)
      if (s.max[a] > s.min[a]) p[a] += (s.max[a] - s.min[a]) * (coordinate++ == 0 ? first : second);
    return p;
  };
  return {at(low, place[0], place[1]), at(high, place[2], place[3])};
}

}  // namespace

ProvenClassifier::ProvenClassifier(const PreparedMesh& mesh, const Tracer& tracer, const ProvenOptions& options)
    : options_(options),
      triangle_count_(mesh.triangles.size()),
      first_look_(tracer, 16, options.seed),
      statistical_(tracer, options.statistical_samples ? options.statistical_samples : 81, options.seed + 1),
      groups_(positions_in_grid(mesh), mesh.triangles),
      surface_(positions_in_grid(mesh), mesh.triangles, pair_edges(mesh.positions, mesh.triangles)) {}

bool ProvenClassifier::prove_clear(const Cell& cell, Workspace& workspace) const {
  const Shaft shaft = make_shaft(cell);
  return !groups_.any_meets(shaft, workspace.path.of(groups_, cell, shaft));
}

bool ProvenClassifier::prove_blocked(const Cell& cell, Workspace& workspace) const {
  const Shaft shaft = make_shaft(cell);
  const Candidates& candidates = workspace.path.of(groups_, cell, shaft);
  auto& crossed = workspace.crossings;
  const bool sure = std::any_of(kPlaces.begin(), kPlaces.end(), [&](const auto& place) {
    return crossings(groups_, candidates, line_through(cell, place), crossed);
  });
  if (!sure) return false;

  // A blocking sheet is crossed by each line an odd number of times, so by this one: every sheet is found that there is.
  // First the outermost triangles, from both ends, then those between.
  Surface::Flood& flood = workspace.flood;
  flood.begin(triangle_count_);
  size_t tried = 0;
  for (size_t i = 0; i < crossed.size() && tried < kMostSheets; ++i) {
    const uint32_t seed = crossed[i % 2 ? crossed.size() - 1 - i / 2 : i / 2].triangle;
    if (flood.reached_before(seed)) continue;
    ++tried;
    if (!surface_.flood(shaft, seed, kFloodLimit, flood)) continue;
    if (std::count_if(crossed.begin(), crossed.end(), [&](const Crossing& c) { return flood.reached(c.triangle); }) % 2)
      return true;
  }
  return false;
}

uint32_t ProvenClassifier::classify(const Cell& cell, bool deepest, Workspace& workspace) const {
  const uint32_t undecided = deepest ? kUnclassified : kDeeper;
  const CellVerdict look = first_look_.classify(cell, workspace.rays);
  if (look == CellVerdict::mixed) return undecided;
  ++workspace.proofs;
  if (look == CellVerdict::clear) return prove_clear(cell, workspace) ? kClear : undecided;
  if (prove_blocked(cell, workspace)) return kBlocked;
  if (!deepest || options_.statistical_samples == 0) return undecided;
  return statistical_.classify(cell, workspace.rays) == CellVerdict::blocked ? kStatisticallyBlocked : kUnclassified;
}

}  // namespace vcd
