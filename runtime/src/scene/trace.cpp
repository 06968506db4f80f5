#include "scene/trace.h"

#include <array>
#include <bit>

#include <vcd/format/meets.h>

namespace vcd {
namespace {

// row · (v, 1), each product and each sum rounded.
std::array<float, 3> in_world(const Transform& to_world, const float (&v)[3]) {
  std::array<float, 3> world;
  for (size_t i = 0; i < 3; ++i) {
    const float(&row)[4] = to_world.rows[i];
    world[i] = ((row[0] * v[0] + row[1] * v[1]) + row[2] * v[2]) + row[3];
  }
  return world;
}

bool is_finite(const Triangle& triangle) {
  for (const auto& corner : triangle)
    for (float x : corner)
      if (!std::isfinite(x)) return false;
  return true;
}

}  // namespace

bool blocks_in_world(const HierarchyView& view, const Transform& to_world, const Segment& segment) noexcept {
  const auto meets_leaf = [&]<uint32_t kVertices>(const HierarchyLeaf<kVertices>& leaf) {
    for (uint32_t left = leaf.present; left != 0; left &= left - 1) {
      const int i = std::countr_zero(left);
      Triangle triangle;
      for (size_t k = 0; k < 3; ++k) {
        const uint32_t v = leaf.corner[k][i] % kVertices;
        triangle[k] = in_world(to_world, {leaf.vertex[0][v], leaf.vertex[1][v], leaf.vertex[2][v]});
      }
      if (is_finite(triangle) && meets(segment, triangle)) return true;
    }
    return false;
  };
  // Nodes and leaves in the order of the section: spec/vcd-format.md, "HIER section".
  uint32_t waiting[kMostLevels * kNodeWidth];
  size_t count = 0;
  waiting[count++] = kRootUnit;
  while (count > 0) {
    const HierarchyNode& node = view.node(waiting[--count]);
    for (const uint32_t child : node.child) {
      if (child == kNoChild) break;
      if ((child & kLeafChild) == 0) waiting[count++] = child;
      else if (with_leaf(view, child, meets_leaf)) return true;
    }
  }
  return false;
}

}  // namespace vcd
