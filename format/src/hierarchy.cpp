#include <vcd/format/hierarchy.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "reading.h"

namespace vcd {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Box {
  std::array<float, 3> min{kInfinity, kInfinity, kInfinity}, max{-kInfinity, -kInfinity, -kInfinity};

  void add(const Box& other) {
    for (size_t a = 0; a < 3; ++a) min[a] = std::min(min[a], other.min[a]), max[a] = std::max(max[a], other.max[a]);
  }
  // To the bit, but that -0 is 0.
  bool operator==(const Box&) const = default;
};

Box child_box(const HierarchyNode& node, size_t i) {
  return {{node.min[0][i], node.min[1][i], node.min[2][i]}, {node.max[0][i], node.max[1][i], node.max[2][i]}};
}

bool is_number(float x) { return std::isfinite(x); }

// One pass over the section in the order of its layout: a node, its leaves, then what is below its other children.
class Check {
 public:
  Check(Bytes section, bool canonical) : section_(section), view_{section.data()}, canonical_(canonical) {}

  std::optional<HierarchyFault> run() {
    const HierarchyHeader& h = view_.header();
    if (section_.size() != size_t{h.units} * kUnitBytes || h.units > kUnitMask || h.levels == 0 ||
        h.levels > kMostLevels || !all_zero(h.reserved))
      return HierarchyFault{HierarchyFault::Kind::size, 0};
    for (int a = 0; a < 3; ++a)
      if (!is_number(h.box_min[a]) || !is_number(h.box_max[a]) || !(h.box_min[a] <= h.box_max[a]))
        return HierarchyFault{HierarchyFault::Kind::box, 0};
    const float greatest = greatest_coordinate(h.box_min, h.box_max);
    if (greatest < kLeastHierarchyCoordinate || greatest > kMostHierarchyCoordinate)
      return HierarchyFault{HierarchyFault::Kind::box, 0};
    next_ = kRootUnit;
    Box box;
    if (!subtree(kRootUnit, 1, box)) return fault_;
    const bool fits = next_ == h.units && nodes_ == h.node_count && leaves_ == h.leaf_count && levels_ == h.levels &&
                      (!canonical_ || triangles_ == h.triangle_count);
    if (!fits) return HierarchyFault{HierarchyFault::Kind::size, 0};
    if (canonical_ &&
        box != Box{{h.box_min[0], h.box_min[1], h.box_min[2]}, {h.box_max[0], h.box_max[1], h.box_max[2]}})
      return HierarchyFault{HierarchyFault::Kind::box, 0};
    return std::nullopt;
  }

 private:
  bool fail(HierarchyFault::Kind kind, uint32_t unit) {
    fault_ = {kind, unit};
    return false;
  }

  // Whether `child` begins at the next unit that is not taken, and ends inside the section.
  bool take(uint32_t child) {
    if ((child & kUnitMask) != next_ || units_of(child) > view_.header().units - next_)
      return fail(HierarchyFault::Kind::order, next_);
    next_ += units_of(child);
    return true;
  }

  // Recursion is as deep as the levels, kMostLevels at most.
  bool subtree(uint32_t unit, uint32_t level, Box& box) {
    if (level > kMostLevels) return fail(HierarchyFault::Kind::order, unit);
    if (!take(unit)) return false;
    levels_ = std::max(levels_, level), ++nodes_;
    const HierarchyNode& node = view_.node(unit);
    uint32_t count = 0;
    while (count < kNodeWidth && node.child[count] != kNoChild) ++count;
    if (count == 0) return fail(HierarchyFault::Kind::order, unit);
    for (uint32_t i = count; i < kNodeWidth; ++i)
      if (node.child[i] != kNoChild || (canonical_ && child_box(node, i) != Box{}))
        return fail(HierarchyFault::Kind::order, unit);
    for (uint32_t i = 0; i < count; ++i)
      if ((node.child[i] & kLeafChild) && !leaf(node.child[i], child_box(node, i), box)) return false;
    for (uint32_t i = 0; i < count; ++i) {
      if (node.child[i] & kLeafChild) continue;
      if (node.child[i] > kUnitMask) return fail(HierarchyFault::Kind::order, unit);
      Box below;
      if (!subtree(node.child[i], level + 1, below)) return false;
      if (canonical_ && below != child_box(node, i)) return fail(HierarchyFault::Kind::box, unit);
      box.add(below);
    }
    return true;
  }

  bool leaf(uint32_t child, const Box& expected, Box& box) {
    const uint32_t unit = next_;
    if ((child & ~(kLeafChild | kLargeChild | kUnitMask)) != 0) return fail(HierarchyFault::Kind::order, unit);
    if (!take(child)) return false;
    ++leaves_;
    if (!canonical_) return true;
    return with_leaf(view_, child, [&](const auto& leaf) { return leaf_is_canonical(leaf, unit, expected, box); });
  }

  template <uint32_t kVertices>
  bool leaf_is_canonical(const HierarchyLeaf<kVertices>& leaf, uint32_t unit, const Box& expected, Box& box) {
    const auto count = static_cast<uint32_t>(std::popcount(leaf.present));
    if (count == 0 || leaf.present != (1u << count) - 1 || leaf.reserved != 0 || !all_zero(leaf.padding))
      return fail(HierarchyFault::Kind::leaf, unit);
    triangles_ += count;
    std::array<bool, kVertices> used{};
    for (uint32_t i = 0; i < kNodeWidth; ++i)
      for (const auto& corners : leaf.corner) {
        if (i < count ? corners[i] >= kVertices : corners[i] != 0) return fail(HierarchyFault::Kind::leaf, unit);
        if (i < count) used[corners[i]] = true;
      }
    uint32_t vertices = kVertices;
    while (!used[vertices - 1]) --vertices;
    Box own;
    for (uint32_t v = 0; v < kVertices; ++v) {
      if (v < vertices && !used[v]) return fail(HierarchyFault::Kind::leaf, unit);
      for (size_t a = 0; a < 3; ++a) {
        const float x = leaf.vertex[a][v];
        if (!is_number(x) || (v >= vertices && x != leaf.vertex[a][vertices - 1]))
          return fail(HierarchyFault::Kind::leaf, unit);
        own.min[a] = std::min(own.min[a], x), own.max[a] = std::max(own.max[a], x);
      }
    }
    float extent = 0;
    for (size_t a = 0; a < 3; ++a) extent = std::max(extent, extent_above(own.min[a], own.max[a]));
    if (own != expected || extent != leaf.extent) return fail(HierarchyFault::Kind::box, unit);
    box.add(own);
    return true;
  }

  const Bytes section_;
  const HierarchyView view_;
  const bool canonical_;
  uint32_t next_ = 0;  // unit
  uint32_t nodes_ = 0, leaves_ = 0, levels_ = 0;
  uint64_t triangles_ = 0;
  HierarchyFault fault_{};
};

}  // namespace

float greatest_coordinate(const float (&box_min)[3], const float (&box_max)[3]) {
  float greatest = 0;
  for (int a = 0; a < 3; ++a) greatest = std::max({greatest, std::abs(box_min[a]), std::abs(box_max[a])});
  return greatest;
}

float extent_above(float min, float max) {
  const float extent = max - min, part = extent - max;
  const float error = (max - (extent - part)) + (-min - part);  // exact: Knuth's sum of two
  return error > 0 ? std::nextafter(extent, kInfinity) : extent;
}

std::optional<HierarchyFault> check_hierarchy(Bytes section, CheckLevel level) {
  if (section.size() < sizeof(HierarchyHeader) + sizeof(HierarchyNode) || section.size() % kUnitBytes != 0)
    return HierarchyFault{HierarchyFault::Kind::size, 0};
  return Check(section, level >= CheckLevel::canonical).run();
}

namespace {

FindingId finding_of(HierarchyFault::Kind kind) {
  switch (kind) {
    case HierarchyFault::Kind::size: return FindingId::hierarchy_size;
    case HierarchyFault::Kind::order: return FindingId::hierarchy_order;
    case HierarchyFault::Kind::leaf: return FindingId::hierarchy_leaf;
    case HierarchyFault::Kind::box: break;
  }
  return FindingId::hierarchy_box;
}

bool read_hierarchy(Reading& reading, uint32_t index, const SectionEntry& e) {
  const std::string owner = "object " + std::to_string(index);
  const Bytes bytes = mapped_bytes(reading, e, owner);
  if (bytes.empty()) return e.logical_size != 0 ? false : reading.report(FindingId::hierarchy_size, e.offset, owner);
  if (const auto fault = check_hierarchy(bytes, reading.level))
    return reading.report(finding_of(fault->kind), e.offset + (is_zstd(e) ? 0 : uint64_t{fault->unit} * kUnitBytes),
                          owner + ", unit " + std::to_string(fault->unit));
  ObjectContents& object = reading.contents.objects[index];
  object.hierarchy = {bytes.data()};
  const HierarchyHeader& h = object.hierarchy.header();
  if (h.triangle_count != object.record->triangle_count)
    return reading.report(FindingId::hierarchy_size, e.offset, owner + ": not the triangles of its record");
  for (int a = 0; a < 3; ++a)
    if (h.box_min[a] < object.record->box_min[a] || h.box_max[a] > object.record->box_max[a])
      return reading.report(FindingId::hierarchy_box, e.offset, owner + ": not inside the box of its record");
  return true;
}

}  // namespace

bool read_hierarchies(Reading& reading) {
  for (uint32_t i = 0; i < reading.hierarchies.size(); ++i)
    if (reading.hierarchies[i] != kNone &&
        !read_hierarchy(reading, i, reading.contents.sections[reading.hierarchies[i]]))
      return false;
  return true;
}

}  // namespace vcd
