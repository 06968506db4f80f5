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

// Edges that aimed rays are spread over.
constexpr size_t kMostEdges = 256;

// Lanes 8 to 15 in the place of lanes 0 to 7.
RTCRay16 second_half(const RTCRay16& rays) {
  RTCRay16 half = rays;
  for (int k = 0; k < 8; ++k) {
    half.org_x[k] = rays.org_x[k + 8], half.org_y[k] = rays.org_y[k + 8], half.org_z[k] = rays.org_z[k + 8];
    half.dir_x[k] = rays.dir_x[k + 8], half.dir_y[k] = rays.dir_y[k + 8], half.dir_z[k] = rays.dir_z[k + 8];
  }
  return half;
}

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
      tracer_(tracer),
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

// No proof: first rays where a gap would be, then rays all over the cell.
bool ProvenClassifier::statistically_blocked(const Cell& cell, Workspace& workspace) const {
  const Shaft shaft = make_shaft(cell);
  silhouette_edges(groups_, surface_, cell, shaft, workspace.path.of(groups_, cell, shaft), kMostEdges, workspace.edges);
  RTCRay16 rays;
  const uint32_t aimed = aim_rays(cell, options_.seed + 2, workspace.edges, rays);
  const uint32_t width = tracer_.packet_width();
  for (uint32_t first = 0; first < aimed; first += width) {
    const uint32_t count = std::min(aimed - first, width);
    workspace.rays += count;
    RTCRay16 packet = first == 0 ? rays : second_half(rays);
    if (tracer_.occluded(packet, count, true) != (1u << count) - 1) return false;
  }
  return statistical_.classify(cell, workspace.rays) == CellVerdict::blocked;
}

uint32_t ProvenClassifier::classify(const Cell& cell, bool deepest, Workspace& workspace) const {
  const uint32_t undecided = deepest ? kUnclassified : kDeeper;
  const CellVerdict look = first_look_.classify(cell, workspace.rays);
  if (look == CellVerdict::mixed) return undecided;
  ++workspace.proofs;
  if (look == CellVerdict::clear) return prove_clear(cell, workspace) ? kClear : undecided;
  if (prove_blocked(cell, workspace)) return kBlocked;
  if (!deepest || options_.statistical_samples == 0) return undecided;
  return statistically_blocked(cell, workspace) ? kStatisticallyBlocked : kUnclassified;
}

}  // namespace vcd
