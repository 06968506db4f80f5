#include <vcd/format/horizon.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <vector>

#include "reading.h"

namespace vcd {
namespace {

using Kind = HorizonFault::Kind;

// Of a sound hierarchy: by unit, the triangles of the leaf that begins there; 0 where none does.
std::vector<uint8_t> leaf_sizes(const HierarchyView& hierarchy) {
  std::vector<uint8_t> sizes(hierarchy.header().units);
  std::vector<uint32_t> nodes{kRootUnit};
  while (!nodes.empty()) {
    const HierarchyNode& node = hierarchy.node(nodes.back());
    nodes.pop_back();
    for (const uint32_t child : node.child) {
      if (child == kNoChild) break;
      if ((child & kLeafChild) == 0) nodes.push_back(child);
      else
        sizes[child & kUnitMask] = with_leaf(
            hierarchy, child, [](const auto& leaf) { return static_cast<uint8_t>(std::popcount(leaf.present)); });
    }
  }
  return sizes;
}

bool is_share(float x) { return x >= 0 && x <= 1; }

bool slopes_ascend(const float (&slope)[kHorizonSlopes]) {
  if (!(slope[0] > 0)) return false;
  for (uint32_t i = 1; i < kHorizonSlopes; ++i)
    if (!(slope[i - 1] <= slope[i])) return false;
  return slope[kHorizonNever - 1] <= horizon::kSteepest &&
         slope[kHorizonNever] == std::numeric_limits<float>::infinity();
}

}  // namespace

std::optional<HorizonFault> check_horizon(Bytes section, const HierarchyView& hierarchy, CheckLevel level) {
  if (section.size() < sizeof(HorizonHeader)) return HorizonFault{Kind::size, 0};
  const HorizonView view{section.data()};
  const HorizonHeader& h = view.header();
  if (view.size() != section.size() || h.reserved != 0 || !all_zero(h.padding) || !is_share(h.uniform) ||
      !is_share(h.cosine))
    return HorizonFault{Kind::size, 0};
  if (!std::ranges::all_of(h.slope, slopes_ascend)) return HorizonFault{Kind::slopes, offsetof(HorizonHeader, slope)};
  const bool canonical = level >= CheckLevel::canonical;
  const std::vector<uint8_t> sizes = canonical ? leaf_sizes(hierarchy) : std::vector<uint8_t>();
  for (uint32_t i = 0; i < h.entries; ++i) {
    const HorizonEntry& entry = view.entries()[i];
    const HorizonFault fault{Kind::place, sizeof(HorizonHeader) + i * sizeof(HorizonEntry)};
    const uint32_t leaf = leaf_of(entry.place), unit = leaf & kUnitMask, units = hierarchy.header().units;
    if (unit > units || units_of(leaf) > units - unit) return fault;
    if (!canonical) continue;
    if (entry.place == 0 ? codes_of(entry) != ~uint64_t{0} : triangle_of(entry.place) >= sizes[unit]) return fault;
  }
  return std::nullopt;
}

namespace {

FindingId finding_of(Kind kind) {
  switch (kind) {
    case Kind::size: return FindingId::horizon_size;
    case Kind::slopes: return FindingId::horizon_slopes;
    case Kind::place: break;
  }
  return FindingId::horizon_place;
}

bool read_horizon(Reading& reading, uint32_t index, const SectionEntry& e) {
  const std::string owner = "object " + std::to_string(index);
  ObjectContents& object = reading.contents.objects[index];
  if (!object.hierarchy || e.logical_size == 0) return reading.report(FindingId::horizon_size, e.offset, owner);
  const Bytes bytes = mapped_bytes(reading, e, owner);
  if (bytes.empty()) return false;
  if (const auto fault = check_horizon(bytes, object.hierarchy, reading.level))
    return reading.report(finding_of(fault->kind), e.offset + (is_zstd(e) ? 0 : fault->offset),
                          owner + ", byte " + std::to_string(fault->offset) + " of its horizons");
  object.horizon = {bytes.data()};
  return true;
}

}  // namespace

bool read_horizons(Reading& reading) {
  for (uint32_t i = 0; i < reading.horizons.size(); ++i)
    if (reading.horizons[i] != kNone && !read_horizon(reading, i, reading.contents.sections[reading.horizons[i]]))
      return false;
  return true;
}

}  // namespace vcd
