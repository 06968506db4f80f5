#include <vcd/baker/horizon.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <new>
#include <span>
#include <vector>

#include <tbb/parallel_for.h>

#include <vcd/format/checksum.h>
#include <vcd/format/layout.h>

#include "hierarchy/stop.h"
#include "horizon/level_codes.h"
#include "horizon/trace_horizon.h"
#include "seconds_since.h"

namespace vcd::baker {
namespace {

constexpr HorizonEntry kNoHorizon{0, {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}};

// Of a triangle of the mesh: the better of its sides.
struct TriangleHorizon {
  uint32_t place = 0;
  Levels levels{};
  double area = 0;
  uint32_t sides = 1;  // from which something can be seen, or 1
};

// Leaves in the order of the section, as children's words.
std::vector<uint32_t> leaves_of(const HierarchyView& hierarchy) {
  std::vector<uint32_t> leaves, nodes{kRootUnit};
  while (!nodes.empty()) {
    const HierarchyNode& node = hierarchy.node(nodes.back());
    nodes.pop_back();
    for (uint32_t i = 0; i < kNodeWidth && node.child[i] != kNoChild; ++i)
      (node.child[i] & kLeafChild ? leaves : nodes).push_back(node.child[i]);
  }
  return leaves;
}

// The number of a triangle in the mesh, by its corners' bits, whatever their order.
uint32_t number_of(const PreparedMesh& mesh, const Triangle& corners) {
  TriangleIndices t;
  for (size_t k = 0; k < 3; ++k) {
    const auto at = std::ranges::lower_bound(mesh.positions, corners[k]);
    t[k] = static_cast<uint32_t>(at - mesh.positions.begin());
  }
  std::ranges::sort(t);
  return static_cast<uint32_t>(std::ranges::lower_bound(mesh.triangles, t) - mesh.triangles.begin());
}

double area_of(const Triangle& t) {
  double a[3], b[3];
  for (size_t i = 0; i < 3; ++i) a[i] = double{t[1][i]} - t[0][i], b[i] = double{t[2][i]} - t[0][i];
  const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
  return 0.5 * std::sqrt(x * x + y * y + z * z);
}

// Triangles of one leaf begin with what set the horizon of the one before.
class LeafHorizons {
 public:
  LeafHorizons(const HierarchyView& hierarchy, float reach) : hierarchy_(hierarchy), reach_(reach) {}

  TriangleHorizon operator()(uint32_t leaf, uint32_t triangle) {
    const Triangle corners = corners_at(hierarchy_, {leaf, triangle});
    TriangleHorizon best;
    best.area = area_of(corners);
    double most = 0;
    uint32_t sides = 0;
    for (uint32_t turned : {0u, 1u}) {
      const uint32_t place = (leaf & kUnitMask) | (leaf & kLargeChild ? kPlaceLarge : 0) |
                             triangle << kPlaceTriangleShift | (turned ? kPlaceTurned : 0);
      HorizonFrame frame;
      if (!frame_at(hierarchy_, place, frame)) continue;
      const Viewpoint from(frame, corners, reach_);
      if (!from.usable()) continue;
      const Levels levels = trace_horizon(hierarchy_, from, setters_[turned]);
      const double worth = mean(levels).worth();
      sides += worth > 0;
      if (worth > most) most = worth, best.place = place, best.levels = levels;
    }
    best.sides = std::max(sides, 1u);
    return best;
  }

 private:
  const HierarchyView& hierarchy_;
  const float reach_;
  std::array<Setters, 2> setters_{};
};

// By number in the mesh, of every `step`th leaf's triangles; others have no area. Unfinished if it was stopped.
std::vector<TriangleHorizon> trace_all(const PreparedMesh& mesh, const HierarchyView& hierarchy, size_t step,
                                       Stop& stop) {
  const HierarchyHeader& h = hierarchy.header();
  const float reach = greatest_coordinate(h.box_min, h.box_max);
  const std::vector<uint32_t> leaves = leaves_of(hierarchy);
  std::vector<TriangleHorizon> horizons(mesh.triangles.size());
  tbb::parallel_for(size_t{0}, leaves.size(), step, [&](size_t i) {
    if (stop.now()) return;
    LeafHorizons of_leaf(hierarchy, reach);
    const auto count = with_leaf(hierarchy, leaves[i], [](const auto& leaf) { return std::popcount(leaf.present); });
    for (uint32_t t = 0; t < static_cast<uint32_t>(count); ++t)
      horizons[number_of(mesh, corners_at(hierarchy, {leaves[i], t}))] = of_leaf(leaves[i], t);
  });
  return horizons;
}

LevelTables tables_for(std::span<const TriangleHorizon> horizons) {
  std::vector<WeightedLevels> weighted;
  for (const TriangleHorizon& horizon : horizons)
    if (horizon.place != 0) weighted.push_back({&horizon.levels, horizon.area});
  return choose_tables(weighted);
}

// Of the mesh's triangles, and what they answer.
struct Entries {
  std::vector<HorizonEntry> entries;
  HorizonShare share;
};

Entries encode_all(std::span<const TriangleHorizon> horizons, const LevelTables& tables) {
  Entries all;
  HorizonShare answered;
  double areas = 0;
  for (const TriangleHorizon& horizon : horizons) {
    areas += horizon.area * horizon.sides;
    HorizonEntry& entry = all.entries.emplace_back(kNoHorizon);
    if (horizon.place == 0) continue;
    const Encoded encoded = encode(horizon.levels, tables);
    entry.place = horizon.place | encoded.table << kPlaceTableShift;
    std::memcpy(entry.codes, &encoded.codes, sizeof entry.codes);
    answered.uniform += horizon.area * encoded.answered.uniform;
    answered.cosine += horizon.area * encoded.answered.cosine;
  }
  if (areas > 0) all.share = {answered.uniform / areas, answered.cosine / areas};
  return all;
}

AlignedBytes emit(const PreparedMesh& mesh, const Entries& all, const LevelTables& tables) {
  HorizonHeader header{};
  header.entries = static_cast<uint32_t>(mesh.source_triangles.size());
  header.order_xxh3 = order_of(mesh);
  header.uniform = static_cast<float>(all.share.uniform), header.cosine = static_cast<float>(all.share.cosine);
  for (uint32_t i = 0; i < kHorizonTables; ++i) std::ranges::transform(tables[i], header.slope[i], stored_slope);
  AlignedBytes section = allocate_aligned(sizeof header + mesh.source_triangles.size() * sizeof(HorizonEntry));
  if (!section.data) throw std::bad_alloc();
  std::memcpy(section.data.get(), &header, sizeof header);
  std::byte* at = section.data.get() + sizeof header;
  for (const uint32_t triangle : mesh.source_triangles) {
    const HorizonEntry& entry = triangle == kNone ? kNoHorizon : all.entries[triangle];
    std::memcpy(at, &entry, sizeof entry);
    at += sizeof entry;
  }
  return section;
}

}  // namespace

bool can_have_horizons(const HierarchyView& hierarchy) {
  return hierarchy && hierarchy.header().units <= kPlaceUnitMask;
}

uint64_t order_of(const PreparedMesh& mesh) { return checksum(std::as_bytes(std::span(mesh.source_triangles))); }

std::optional<HorizonForecast> forecast_horizons(const PreparedMesh& mesh, const HierarchyView& hierarchy,
                                                 const std::function<bool()>& ask) {
  using Clock = std::chrono::steady_clock;
  constexpr uint32_t kMostLeaves = 256;
  const size_t step = hierarchy.header().leaf_count / kMostLeaves + 1;
  Stop stop(ask);
  const auto start = Clock::now();
  const std::vector<TriangleHorizon> horizons = trace_all(mesh, hierarchy, step, stop);
  if (stop.stopped()) return std::nullopt;
  HorizonForecast forecast;
  forecast.seconds = static_cast<double>(step) * seconds_since(start);
  forecast.share = encode_all(horizons, tables_for(horizons)).share;
  if (forecast.share.cosine >= kLeastHorizonShare)
    forecast.bytes = sizeof(HorizonHeader) + mesh.source_triangles.size() * sizeof(HorizonEntry);
  return forecast;
}

std::optional<Horizons> build_horizons(const PreparedMesh& mesh, const HierarchyView& hierarchy,
                                       const std::function<bool()>& ask) {
  Stop stop(ask);
  const std::vector<TriangleHorizon> horizons = trace_all(mesh, hierarchy, 1, stop);
  if (stop.stopped()) return std::nullopt;
  const LevelTables tables = tables_for(horizons);
  const Entries all = encode_all(horizons, tables);
  if (all.share.cosine < kLeastHorizonShare) return Horizons{{}, all.share};
  return Horizons{emit(mesh, all, tables), all.share};
}

}  // namespace vcd::baker
