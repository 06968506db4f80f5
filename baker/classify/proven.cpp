#include "proven.h"

#include <algorithm>
#include <array>

#include <vcd/format/line_cell.h>

#include "classify/random.h"
#include "prepare/topology.h"

namespace vcd::baker {
namespace {

// Sheets of more triangles are given up: deeper cells see less of them.
constexpr uint32_t kFloodLimit = 2000;
// Sheets that are tried before a cell is given up.
constexpr size_t kMostSheets = 8;

// Edges at which rays are aimed.
constexpr size_t kMostEdges = 8;

// Proofs of blocked that tell whether they are worth trying, and the cells among which those are looked for.
constexpr uint32_t kTrials = 256, kMostLooks = 8192, kTrialLevel = 5;
// They are, if one in so many succeeds.
constexpr uint32_t kOneSucceedsIn = 8;

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
constexpr std::array<std::array<double, 4>, 3> kPlaces = {
    {{0.5, 0.5, 0.5, 0.5}, {0.4375, 0.5625, 0.578125, 0.453125}, {0.578125, 0.4375, 0.484375, 0.609375}}};

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

ProvenClassifier::ProvenClassifier(const GridMesh& mesh, const Tracer& tracer, const ProvenOptions& options)
    : seed_(options.seed),
      statistical_tier_(options.statistical_tier),
      tracer_(tracer),
      triangle_count_(mesh.triangles().size()),
      first_look_(tracer, 16, options.seed),
      groups_(mesh.positions, mesh.triangles()),
      surface_(mesh.positions, mesh.triangles(), pair_edges(mesh.source.positions, mesh.triangles())),
      rays_alone_(options.statistical_tier && proofs_fail()),
      samples_(options.samples ? options.samples
               : rays_alone_   ? 81
                               : 256),
      statistical_(tracer, samples_, options.seed + 1),
      parent_rays_(tracer, 256, options.seed + 3) {}

bool ProvenClassifier::proofs_fail() const {
  Workspace workspace;
  uint32_t tried = 0, succeeded = 0;
  for (uint32_t i = 0; i < kMostLooks && tried < kTrials; ++i) {
    const uint64_t random = mix_bits(kGolden * (i + 1));
    constexpr uint32_t kMask = (1u << kTrialLevel) - 1;
    const auto coordinate = [&](uint32_t k) { return static_cast<uint32_t>(random >> (8 * k)) & kMask; };
    const Cell cell{i % kFacePairs, kTrialLevel, coordinate(0), coordinate(1), coordinate(2), coordinate(3)};
    if (first_look_.classify(cell, workspace.rays) != CellVerdict::blocked) continue;
    ++tried;
    succeeded += prove_blocked(cell, workspace);
  }
  return succeeded * kOneSucceedsIn < tried;
}

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

  // A blocking sheet is crossed by each line an odd number of times, so by this one: every sheet is found that there
  // is. First the outermost triangles, from both ends, then those between.
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

ProvenClassifier::Attempt ProvenClassifier::try_blocked(const Cell& cell, Workspace& workspace) const {
  if (first_look_.classify(cell, workspace.rays) != CellVerdict::blocked) return {};
  workspace.flood.begin(triangle_count_);
  const bool is_proven = prove_blocked(cell, workspace);
  return {true, is_proven, workspace.flood.ended_at()};
}

// No proof: first rays where a gap would be, then rays all over the cell. In foliage there are edges everywhere, and
// rays all over find as much.
bool ProvenClassifier::statistically_blocked(const Cell& cell, Workspace& workspace) const {
  if (rays_alone_) return statistical_.classify(cell, workspace.rays) == CellVerdict::blocked;
  const Shaft shaft = make_shaft(cell);
  silhouette_edges(groups_, surface_, cell, shaft, workspace.path.of(groups_, cell, shaft), kMostEdges,
                   workspace.edges);
  RTCRay16 rays;
  const uint32_t aimed = aim_rays(cell, seed_ + 2, workspace.edges, rays);
  const uint32_t width = tracer_.packet_width();
  for (uint32_t first = 0; first < aimed; first += width) {
    const uint32_t count = std::min(aimed - first, width);
    workspace.rays += count;
    RTCRay16 packet = first == 0 ? rays : second_half(rays);
    if (tracer_.occluded(packet, count, true) != (1u << count) - 1) return false;
  }
  return statistical_.classify(cell, workspace.rays) == CellVerdict::blocked;
}

// Asked once for its sixteen children, one after the other.
bool ProvenClassifier::parent_blocked(const Cell& parent, Workspace& workspace) const {
  auto& last = workspace.last_parent;
  if (!last.known || last.cell != parent)
    last = {true, parent,
            first_look_.classify(parent, workspace.rays) == CellVerdict::blocked &&
                parent_rays_.classify(parent, workspace.rays) == CellVerdict::blocked};
  return last.blocked;
}

uint32_t ProvenClassifier::classify(const Cell& cell, bool deepest, Workspace& workspace) const {
  const uint32_t undecided = deepest ? kUnclassified : kDeeper;
  if (rays_alone_ && deepest && cell.level > 0 && parent_blocked(cell.parent(), workspace))
    return kStatisticallyBlocked;
  const CellVerdict look = first_look_.classify(cell, workspace.rays);
  if (look == CellVerdict::mixed) return undecided;
  if (look == CellVerdict::clear) return prove_clear(cell, workspace) ? kClear : undecided;
  if (!rays_alone_ && prove_blocked(cell, workspace)) return kBlocked;
  if (!deepest || !statistical_tier_) return undecided;
  return statistically_blocked(cell, workspace) ? kStatisticallyBlocked : kUnclassified;
}

}  // namespace vcd::baker
