// check_hierarchy() on damaged sections: each statement of the specification, broken; every bit; every prefix.
#include <vcd/format/hierarchy.h>

#include <bit>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include <vcd/baker/hierarchy.h>
#include <vcd/runtime/sidecar.h>

#include "support/files.h"
#include "support/meshes.h"
#include "support/special_floats.h"

namespace vcd::test {
using namespace baker;
namespace {

using Kind = HierarchyFault::Kind;

// A surface, and loose triangles, whose leaves are large.
SourceMesh mixed() {
  SourceMesh mesh = sphere(16, 24);
  const SourceMesh loose = leaves(60);
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), loose.positions.begin(), loose.positions.end());
  for (const TriangleIndices& t : loose.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  return mesh;
}

// A section to damage.
struct Section {
  HierarchySection units = *build_hierarchy(*prepare(mixed()));

  HierarchyView view() const { return view_of(units); }
  HierarchyHeader& header() { return const_cast<HierarchyHeader&>(view().header()); }
  HierarchyNode& root() { return node(kRootUnit); }
  HierarchyNode& node(uint32_t child) { return const_cast<HierarchyNode&>(view().node(child)); }
  SmallLeaf& small(uint32_t child) { return const_cast<SmallLeaf&>(view().small_leaf(child)); }
  LargeLeaf& large(uint32_t child) { return const_cast<LargeLeaf&>(view().large_leaf(child)); }

  // The first child of the root, or of a node below it, with these flags; and where its node has it.
  struct Found {
    HierarchyNode* parent;
    uint32_t slot;
    uint32_t child() const { return parent->child[slot]; }
  };
  Found first(uint32_t flags) { return first(flags, kRootUnit); }
  Found first(uint32_t flags, uint32_t below) {
    HierarchyNode& parent = node(below);
    for (uint32_t i = 0; i < kNodeWidth && parent.child[i] != kNoChild; ++i)
      if ((parent.child[i] & (kLeafChild | kLargeChild)) == flags) return {&parent, i};
    for (uint32_t i = 0; i < kNodeWidth && parent.child[i] != kNoChild; ++i)
      if (!(parent.child[i] & kLeafChild))
        if (const Found found = first(flags, parent.child[i]); found.parent) return found;
    return {nullptr, 0};
  }
  uint32_t first_small() { return first(kLeafChild).child(); }
  uint32_t first_large() { return first(kLeafChild | kLargeChild).child(); }
  uint32_t first_node() { return first(0).child(); }

  std::optional<HierarchyFault> check(CheckLevel level) const { return check_hierarchy(bytes_of(units), level); }
};

TEST(CheckHierarchy, AcceptsWhatTheBakerBuilds) {
  Section section;
  for (const CheckLevel level : {CheckLevel::bounds, CheckLevel::checksums, CheckLevel::canonical})
    EXPECT_FALSE(section.check(level));
  ASSERT_GT(section.header().levels, 1u);
  ASSERT_TRUE(section.first(kLeafChild).parent);
  ASSERT_TRUE(section.first(kLeafChild | kLargeChild).parent);
  ASSERT_TRUE(section.first(0).parent);
}

struct SectionDamage {
  const char* what;
  Kind kind;
  CheckLevel level;  // the first that finds it
  std::function<void(Section&)> apply;
};

TEST(CheckHierarchy, FindsEachBrokenStatement) {
  constexpr auto kBounds = CheckLevel::bounds, kCanonical = CheckLevel::canonical;
  const std::vector<SectionDamage> damages = {
      // The header.
      {"more units", Kind::size, kBounds, [](Section& s) { ++s.header().units; }},
      {"fewer units", Kind::size, kBounds, [](Section& s) { --s.header().units; }},
      {"a unit that nothing needs", Kind::size, kBounds,
       [](Section& s) { s.units.emplace_back(), ++s.header().units; }},
      {"more nodes", Kind::size, kBounds, [](Section& s) { ++s.header().node_count; }},
      {"fewer leaves", Kind::size, kBounds, [](Section& s) { --s.header().leaf_count; }},
      {"no levels", Kind::size, kBounds, [](Section& s) { s.header().levels = 0; }},
      {"too many levels", Kind::size, kBounds, [](Section& s) { s.header().levels = kMostLevels + 1; }},
      {"other levels", Kind::size, kBounds, [](Section& s) { ++s.header().levels; }},
      {"more triangles", Kind::size, kCanonical, [](Section& s) { ++s.header().triangle_count; }},
      {"padding", Kind::size, kBounds, [](Section& s) { s.header().reserved[3] = 1; }},
      {"a box that is not finite", Kind::box, kBounds, [](Section& s) { s.header().box_max[1] = kInfinity; }},
      {"a box that is no number", Kind::box, kBounds, [](Section& s) { s.header().box_min[1] = kNaN; }},
      {"a box inside out", Kind::box, kBounds, [](Section& s) { s.header().box_min[2] = s.header().box_max[2] + 1; }},
      {"too large", Kind::box, kBounds,
       [](Section& s) { s.header().box_max[0] = std::nextafter(kMostHierarchyCoordinate, kInfinity); }},
      {"too small", Kind::box, kBounds,
       [](Section& s) {
         for (float* box : {s.header().box_min, s.header().box_max})
           std::fill_n(box, 3, std::nextafter(kLeastHierarchyCoordinate, 0.0f));
       }},
      {"another box", Kind::box, kCanonical,
       [](Section& s) { s.header().box_max[0] = std::nextafter(s.header().box_max[0], kInfinity); }},
      // Words of children.
      {"a child elsewhere", Kind::order, kBounds, [](Section& s) { ++s.root().child[0]; }},
      {"a child past the end", Kind::order, kBounds, [](Section& s) { s.root().child[0] |= kUnitMask; }},
      {"a circle", Kind::order, kBounds,
       [](Section& s) {
         const auto found = s.first(0);
         found.parent->child[found.slot] = kRootUnit;
       }},
      {"bit 29 of a leaf", Kind::order, kBounds,
       [](Section& s) {
         const auto found = s.first(kLeafChild);
         found.parent->child[found.slot] |= 0x20000000;
       }},
      {"bit 29 of a node", Kind::order, kBounds,
       [](Section& s) {
         const auto found = s.first(0);
         found.parent->child[found.slot] |= 0x20000000;
       }},
      {"a large node", Kind::order, kBounds,
       [](Section& s) {
         const auto found = s.first(0);
         found.parent->child[found.slot] |= kLargeChild;
       }},
      {"a small leaf that says it is large", Kind::leaf, kBounds,
       [](Section& s) {
         const auto found = s.first(kLeafChild);
         found.parent->child[found.slot] |= kLargeChild;
       }},
      {"a node without children", Kind::order, kBounds,
       [](Section& s) { std::fill_n(s.node(s.first_node()).child, kNodeWidth, kNoChild); }},
      {"a child behind an absent one", Kind::order, kBounds,
       [](Section& s) {
         HierarchyNode& node = s.root();
         std::swap(node.child[0], node.child[1]);
         node.child[0] = kNoChild;
       }},
      {"an absent child with a box", Kind::order, kCanonical,
       [](Section& s) {
         s.units = *build_hierarchy(*prepare(triangle()));
         s.root().max[2][kNodeWidth - 1] = 0;
       }},
      // Boxes.
      {"a leaf's box too large", Kind::box, kCanonical,
       [](Section& s) {
         const auto found = s.first(kLeafChild);
         float& x = found.parent->max[1][found.slot];
         x = std::nextafter(x, kInfinity);
       }},
      {"a node's box too small", Kind::box, kCanonical,
       [](Section& s) {
         const auto found = s.first(0);
         float& x = found.parent->min[0][found.slot];
         x = std::nextafter(x, kInfinity);
       }},
      {"another extent", Kind::box, kCanonical,
       [](Section& s) {
         float& extent = s.small(s.first_small()).extent;
         extent = std::nextafter(extent, kInfinity);
       }},
      {"a vertex outside its leaf's box", Kind::box, kCanonical,
       [](Section& s) { s.large(s.first_large()).vertex[0][3] = 2; }},
      // Leaves.
      {"no triangle", Kind::leaf, kCanonical, [](Section& s) { s.small(s.first_small()).present = 0; }},
      {"a gap among the triangles", Kind::leaf, kCanonical,
       [](Section& s) { s.small(s.first_small()).present &= 0xFFFE; }},
      {"a leaf's padding", Kind::leaf, kCanonical, [](Section& s) { s.small(s.first_small()).padding[1] = 1; }},
      {"a leaf's other padding", Kind::leaf, kCanonical, [](Section& s) { s.large(s.first_large()).reserved = 1; }},
      {"a corner that is no vertex of a small leaf", Kind::leaf, kCanonical,
       [](Section& s) { s.small(s.first_small()).corner[1][0] = 16; }},
      {"a corner that is no vertex of a large leaf", Kind::leaf, kCanonical,
       [](Section& s) { s.large(s.first_large()).corner[1][0] = 32; }},
      {"a corner of an absent triangle", Kind::leaf, kCanonical,
       [](Section& s) {
         SmallLeaf& leaf = s.small(s.first_small());
         ASSERT_EQ(leaf.present >> 15, 0);
         leaf.corner[2][15] = 1;
       }},
      {"a vertex that nothing uses", Kind::leaf, kCanonical,
       [](Section& s) {
         SmallLeaf& leaf = s.small(s.first_small());
         for (auto& corners : leaf.corner)
           for (uint8_t& c : corners) c = c == 1 ? 0 : c;
       }},
      {"a vertex that is no number", Kind::leaf, kCanonical,
       [](Section& s) { s.small(s.first_small()).vertex[1][0] = kNaN; }},
      {"another vertex behind the last one", Kind::leaf, kCanonical,
       [](Section& s) {
         LargeLeaf& leaf = s.large(s.first_large());
         leaf.vertex[2][31] = leaf.vertex[2][31] + 0.001f;
       }},
  };
  for (const SectionDamage& damage : damages) {
    Section section;
    damage.apply(section);
    EXPECT_EQ(section.check(CheckLevel::bounds).has_value(), damage.level == kBounds) << damage.what;
    const auto fault = section.check(kCanonical);
    ASSERT_TRUE(fault) << damage.what;
    EXPECT_EQ(fault->kind, damage.kind) << damage.what;
    EXPECT_LT(fault->unit, section.units.size()) << damage.what;
  }
}

TEST(CheckHierarchy, RefusesTooManyLevels) {
  // A chain of nodes with one child each, and one leaf at its end.
  const auto chain = [](uint32_t levels) {
    const HierarchySection one = *build_hierarchy(*prepare(triangle()));
    HierarchySection units{one[0]};
    for (uint32_t level = 0; level < levels; ++level) units.insert(units.end(), one.begin() + 1, one.begin() + 8);
    units.insert(units.end(), one.begin() + 8, one.end());
    Section section{units};
    for (uint32_t level = 0; level + 1 < levels; ++level) section.node(1 + 7 * level).child[0] = 8 + 7 * level;
    section.node(1 + 7 * (levels - 1)).child[0] = kLeafChild | (1 + 7 * levels);
    section.header().units = static_cast<uint32_t>(units.size());
    section.header().node_count = section.header().levels = levels;
    return section;
  };
  EXPECT_FALSE(chain(kMostLevels).check(CheckLevel::canonical));
  Section deeper = chain(kMostLevels + 1);
  deeper.header().levels = kMostLevels;
  const auto fault = deeper.check(CheckLevel::bounds);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->kind, Kind::order);
}

TEST(CheckHierarchy, RefusesEveryPrefixAndWhatIsBehind) {
  const Section section;
  const Bytes all = bytes_of(section.units);
  for (size_t size = 0; size < all.size(); size += size < 1024 ? 1 : 64)
    ASSERT_TRUE(check_hierarchy(all.first(size), CheckLevel::bounds)) << size;
}

// Bounds: no flipped bit of header or child can be missed. Canonical: nor one of anything but vertices within their
// box, and corners, which only the mesh can tell; and but the sign of a zero.
TEST(CheckHierarchy, FindsEveryFlippedBitThatItPromises) {
  Section section;
  const auto flips_found = [&](void* at, size_t bytes, CheckLevel level) {
    auto* const raw = static_cast<uint8_t*>(at);
    for (size_t bit = 0; bit < 8 * bytes; ++bit) {
      raw[bit / 8] ^= static_cast<uint8_t>(1u << bit % 8);
      EXPECT_TRUE(section.check(level)) << "bit " << bit;
      raw[bit / 8] ^= static_cast<uint8_t>(1u << bit % 8);
    }
  };
  const auto float_flips_found = [&](float& x) {
    const float right = x;
    for (uint32_t bit = 0; bit < 32; ++bit) {
      x = std::bit_cast<float>(std::bit_cast<uint32_t>(right) ^ 1u << bit);
      if (x == right) continue;
      EXPECT_TRUE(section.check(CheckLevel::canonical)) << "bit " << bit;
    }
    x = right;
  };
  flips_found(&section.header(), offsetof(HierarchyHeader, triangle_count), CheckLevel::bounds);
  flips_found(section.header().reserved, sizeof section.header().reserved, CheckLevel::bounds);
  flips_found(&section.header().triangle_count, sizeof section.header().triangle_count, CheckLevel::canonical);
  for (HierarchyNode* node : {&section.root(), &section.node(section.first_node())}) {
    flips_found(node->child, sizeof node->child, CheckLevel::bounds);
    for (size_t a = 0; a < 3; ++a)
      for (uint32_t i = 0; i < kNodeWidth; ++i) float_flips_found(node->min[a][i]), float_flips_found(node->max[a][i]);
  }
  LargeLeaf& leaf = section.large(section.first_large());
  flips_found(&leaf.present, sizeof leaf.present + sizeof leaf.reserved, CheckLevel::canonical);
  flips_found(leaf.padding, sizeof leaf.padding, CheckLevel::canonical);
  float_flips_found(leaf.extent);
}

TEST(ExtentAbove, IsTheLeastFloatThatIsNotBelow) {
  EXPECT_EQ(extent_above(-1, 2), 3);
  const float above = extent_above(-0x1p-30f, 1);  // 1 + 2^-30 is no float
  EXPECT_EQ(above, std::nextafter(1.0f, 2.0f));
  EXPECT_EQ(extent_above(0x1p-30f, 1), 1.0f);
  EXPECT_EQ(extent_above(-0x1p-149f, 0x1p40f), std::nextafter(0x1p40f, kInfinity));
}

// A sidecar in memory that does not begin at a multiple of 64 is read from a copy of the section.
TEST(HierarchyInSidecars, IsThereWhereverTheBytesBegin) {
  const BakedObject object = must_bake(sphere(), quick(2));
  const auto expected = object.to_write().hierarchy;
  for (const Storage storage : {Storage::raw, Storage::zstd}) {
    const auto file = sidecar_bytes({&object}, storage);
    const AlignedBytes memory = allocate_aligned(file.size() + 8);
    for (const size_t shift : {0, 8}) {
      std::copy(file.begin(), file.end(), memory.data.get() + shift);
      const auto sidecar = Sidecar::open_buffer({memory.data.get() + shift, file.size()}, {});
      ASSERT_TRUE(sidecar.ok()) << sidecar.error().message;
      const HierarchyView view = sidecar->contents().objects[0].hierarchy;
      EXPECT_EQ(reinterpret_cast<uintptr_t>(view.units) % kUnitBytes, 0u);
      EXPECT_TRUE(std::ranges::equal(view.bytes(), expected));
    }
  }
}

}  // namespace
}  // namespace vcd::test
