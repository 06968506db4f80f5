#include "hierarchy/traced.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <vcd/format/meets.h>

namespace vcd {
namespace {

// Finds boxes that a segment could meet.
struct WideRay {
  double origin[3], direction[3], reciprocal[3], t_min, t_max;

  explicit WideRay(const Segment& s) : t_min(s.t_min), t_max(s.t_max) {
    for (int a = 0; a < 3; ++a)
      origin[a] = s.origin[a], direction[a] = s.direction[a], reciprocal[a] = 1 / direction[a];
  }

  // No box that the segment meets is missed. Each distance is rounded three times (difference, reciprocal, product: no
  // over- or underflow between 2^-278 and 2^278), so it is within 4 e of itself; e = 2^-53. Twice that is taken off:
  // Ize, "Robust BVH ray traversal", 2013.
  bool may_meet(const HierarchyNode& node, uint32_t child) const {
    double enter = t_min, leave = t_max;
    for (int a = 0; a < 3; ++a) {
      const double low = node.min[a][child] - origin[a], high = node.max[a][child] - origin[a];
      if (direction[a] == 0) {
        if (low > 0 || high < 0) return false;
        continue;
      }
      const double t0 = low * reciprocal[a], t1 = high * reciprocal[a];
      const double near = std::min(t0, t1), far = std::max(t0, t1);
      enter = std::max(enter, near - 0x1p-50 * std::abs(near));
      leave = std::min(leave, far + 0x1p-50 * std::abs(far));
    }
    return enter <= leave;
  }
};

}  // namespace

Traced traced(const HierarchyView& view) {
  Traced t{view};
  if (!view) return t;
  for (int a = 0; a < 3; ++a) t.min[a] = view.header().box_min[a], t.max[a] = view.header().box_max[a];
  t.reach = greatest_coordinate(view.header().box_min, view.header().box_max);
  return t;
}

bool meets_some(const HierarchyView& view, uint32_t child, uint32_t which, const Segment& segment) noexcept {
  return with_leaf(view, child, [&]<uint32_t kVertices>(const HierarchyLeaf<kVertices>& leaf) {
    const auto vertex = [&](uint32_t triangle, int corner, float(&out)[3]) {
      const uint32_t v = leaf.corner[corner][triangle] % kVertices;
      for (int a = 0; a < 3; ++a) out[a] = leaf.vertex[a][v];
    };
    for (uint32_t left = which & leaf.present; left != 0; left &= left - 1) {
      const auto triangle = static_cast<uint32_t>(std::countr_zero(left));
      float a[3], b[3], c[3];
      vertex(triangle, 0, a), vertex(triangle, 1, b), vertex(triangle, 2, c);
      if (meets(segment, a, b, c)) return true;
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
    if (!ray.may_meet(node, i)) continue;
    if ((child & kLeafChild) == 0) stack[depth++] = {child, 0};
    else if (meets_some(traced.view, child, ~0u, segment)) return true;
  }
  return false;
}

}  // namespace vcd
