#include "hierarchy/traced.h"

#include <array>
#include <bit>
#include <cstdio>
#include <cstdlib>

#include <vcd/format/meets.h>
#include <vcd/format/wide_ray.h>

#include "hierarchy/fan.h"

namespace vcd {
namespace {

bool may_meet(const WideRay& ray, const HierarchyNode& node, uint32_t child) {
  return ray.may_meet([&](size_t a) { return static_cast<double>(node.min[a][child]); },
                      [&](size_t a) { return static_cast<double>(node.max[a][child]); });
}

}  // namespace

void fail_without_hierarchy() noexcept {
  std::fputs("vcd: occluded() of an object without a hierarchy, see has_hierarchy()\n", stderr);
  std::abort();
}

ReachBox reach_box(const float (&min)[3], const float (&max)[3]) {
  ReachBox box;
  for (int a = 0; a < 3; ++a) box.min[a] = min[a], box.max[a] = max[a];
  box.reach = greatest_coordinate(min, max);
  return box;
}

Traced traced(const HierarchyView& view) {
  return view ? Traced{reach_box(view.header().box_min, view.header().box_max), view} : Traced{};
}

bool meets_some(const HierarchyView& view, uint32_t child, uint32_t which, const Segment& segment) noexcept {
  return with_leaf(view, child, [&]<uint32_t kVertices>(const HierarchyLeaf<kVertices>& leaf) {
    const auto vertex = [&](uint32_t v) {
      v %= kVertices;  // whatever the file says
      return std::array{leaf.vertex[0][v], leaf.vertex[1][v], leaf.vertex[2][v]};
    };
    for (uint32_t left = which & leaf.present; left != 0; left &= left - 1) {
      const int i = std::countr_zero(left);
      if (meets(segment, {vertex(leaf.corner[0][i]), vertex(leaf.corner[1][i]), vertex(leaf.corner[2][i])}))
        return true;
    }
    return false;
  });
}

bool occluded_scalar(const Traced& traced, const Segment& segment) noexcept {
  if (!can_meet(segment)) return false;
  const WideRay ray(segment);
  struct Rest {
    uint32_t node, next;  // and the child to go on with
  };
  Rest stack[kMostLevels];
  uint32_t depth = 0;
  stack[depth++] = {kRootUnit, 0};
  while (depth > 0) {
    Rest& rest = stack[depth - 1];
    const HierarchyNode& node = traced.view.node(rest.node);
    if (rest.next == kNodeWidth || node.child[rest.next] == kNoChild) {
      --depth;
      continue;
    }
    const uint32_t i = rest.next++, child = node.child[i];
    if (!may_meet(ray, node, i)) continue;
    if ((child & kLeafChild) == 0) stack[depth++] = {child, 0};
    else if (meets_some(traced.view, child, ~0u, segment)) return true;
  }
  return false;
}

SampleBits occluded_array_scalar(const Traced& object, const Segment* segments, const SampleBits& live) noexcept {
  SampleBits blocked{};
  for (size_t i : live) blocked.set(i, occluded_scalar(object, segments[i]));
  return blocked;
}

SampleBits occluded_fan_scalar(const Traced& object, const Fan& fan) noexcept {
  SampleBits blocked{};
  for (size_t i : fan.live) blocked.set(i, occluded_scalar(object, segment_of(fan, i)));
  return blocked;
}

}  // namespace vcd
