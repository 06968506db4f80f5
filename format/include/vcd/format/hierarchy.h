// The HIER section: a hierarchy of boxes over an object's triangles, for segments that the tree leaves unclassified.
// It is made for one question only, whether anything at all is hit. Normative text: spec/vcd-format.md, "HIER section".
//
// The section is an array of 64-byte units: the header, then nodes and leaves, each a whole number of units. Wide nodes
// follow Wald, Benthin and Boulos, "Getting rid of packets", 2008; leaves share their vertices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include <vcd/format/bytes.h>

namespace vcd {

inline constexpr size_t kUnitBytes = 64;
inline constexpr uint32_t kNodeWidth = 16;      // children of a node, and triangles of a leaf, at most
inline constexpr uint32_t kMostLevels = 64;     // nodes on a path from the root to a leaf
inline constexpr uint32_t kLargeVertices = 32;  // of a large leaf; a small one has 16

// M, the greatest absolute coordinate of the object's vertices: within these bounds the products of float kernels
// neither overflow nor underflow in a way that matters. Objects beyond them have no hierarchy.
inline constexpr float kLeastHierarchyCoordinate = 0x1p-30f, kMostHierarchyCoordinate = 0x1p40f;

struct HierarchyHeader {
  uint32_t units;  // of the section, this header included
  uint32_t node_count;
  uint32_t leaf_count;
  uint32_t levels;  // 1 … kMostLevels
  uint64_t triangle_count;
  float box_min[3], box_max[3];  // of the vertices, exactly
  uint32_t reserved[4];          // zero
};
static_assert(sizeof(HierarchyHeader) == kUnitBytes);

// A child is a word: kNoChild, or the number of the unit where it begins, with kLeafChild for a leaf and kLargeChild
// for a large one. The root, a node, is at unit 1.
inline constexpr uint32_t kLeafChild = 0x80000000, kLargeChild = 0x40000000, kUnitMask = 0x1FFFFFFF,
                          kNoChild = kLeafChild;

// Children stand in the order in which they are best visited; those that are none stand last and have the empty box
// (+infinity to -infinity). A child's box is that of the vertices below it, exactly.
struct alignas(kUnitBytes) HierarchyNode {
  float min[3][kNodeWidth], max[3][kNodeWidth];
  uint32_t child[kNodeWidth];
};
static_assert(sizeof(HierarchyNode) == 7 * kUnitBytes);

// Triangle i, if bit i of `present` is set, has the vertices corner[0 … 2][i]. Present ones come first. Vertices that
// no triangle uses repeat the last one that is used, and corners of triangles that are not present are 0.
template <uint32_t kVertices>
struct alignas(kUnitBytes) HierarchyLeaf {
  float vertex[3][kVertices];
  uint8_t corner[3][kNodeWidth];
  uint16_t present;
  uint16_t reserved;    // zero
  float extent;         // the longest side of the vertices' box, each difference rounded up
  uint32_t padding[2];  // zero
};
using SmallLeaf = HierarchyLeaf<kNodeWidth>;
using LargeLeaf = HierarchyLeaf<kLargeVertices>;
static_assert(sizeof(SmallLeaf) == 4 * kUnitBytes && sizeof(LargeLeaf) == 7 * kUnitBytes);

// The units of what a child's word points to.
constexpr uint32_t units_of(uint32_t child) {
  const bool small = (child & kLeafChild) != 0 && (child & kLargeChild) == 0;
  return static_cast<uint32_t>((small ? sizeof(SmallLeaf) : sizeof(HierarchyNode)) / kUnitBytes);
}

// A section in memory, 64-byte aligned. No bytes: there is no hierarchy.
struct HierarchyView {
  const std::byte* units = nullptr;

  explicit operator bool() const { return units != nullptr; }
  const HierarchyHeader& header() const { return *reinterpret_cast<const HierarchyHeader*>(units); }
  Bytes bytes() const { return units ? Bytes(units, size_t{header().units} * kUnitBytes) : Bytes(); }
  const std::byte* at(uint32_t child) const { return units + size_t{child & kUnitMask} * kUnitBytes; }
  const HierarchyNode& node(uint32_t child) const { return *reinterpret_cast<const HierarchyNode*>(at(child)); }
  const SmallLeaf& small_leaf(uint32_t child) const { return *reinterpret_cast<const SmallLeaf*>(at(child)); }
  const LargeLeaf& large_leaf(uint32_t child) const { return *reinterpret_cast<const LargeLeaf*>(at(child)); }
};
inline constexpr uint32_t kRootUnit = 1;

// Calls f(leaf) with the leaf of a child's word, whichever kind it is, and returns what f does.
template <class F>
decltype(auto) with_leaf(const HierarchyView& hierarchy, uint32_t child, F&& f) {
  return (child & kLargeChild) ? f(hierarchy.large_leaf(child)) : f(hierarchy.small_leaf(child));
}

// What is wrong with a HIER section, and in which unit.
struct HierarchyFault {
  enum class Kind : uint8_t {
    size,   // the header contradicts the section's size, or itself
    order,  // a child does not begin where the layout puts it, leaves the section, or is too deep
    leaf,   // a leaf's indices, its padding, or what it must repeat
    box,    // a box is not that of the vertices below it, or an extent is not that of its leaf
  } kind;
  uint32_t unit;
};

// Looks at a section of 64-byte aligned bytes. With `bounds` at the headers and the children's words: then every query
// stays inside the section and ends. With `canonical` at every byte.
std::optional<HierarchyFault> check_hierarchy(Bytes section, CheckLevel level);

// The greatest absolute coordinate of a box.
float greatest_coordinate(const float (&box_min)[3], const float (&box_max)[3]);
// max - min, rounded up.
float extent_above(float min, float max);

}  // namespace vcd
