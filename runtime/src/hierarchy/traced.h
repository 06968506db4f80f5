// A hierarchy with what every query needs of it, and the reference that all kernels equal.
#pragma once

#include <vcd/format/hierarchy.h>
#include <vcd/format/segment.h>

namespace vcd {

// A box as single segments and arrays are tested against it.
struct ReachBox {
  float min[4] = {}, max[4] = {};  // and 0
  float reach = 0;                 // the greatest absolute coordinate
};
ReachBox reach_box(const float (&min)[3], const float (&max)[3]);

// An object's hierarchy, if it has one, with the box of its vertices. M stands for its reach.
struct Traced : ReachBox {
  HierarchyView view{};
};
Traced traced(const HierarchyView& view);

// Ends the program: what is asked of an object without a hierarchy has no answer.
[[noreturn]] void fail_without_hierarchy() noexcept;

// Whether any triangle meets the segment, exactly: see <vcd/format/meets.h>. In plain C++, for any segment.
bool occluded_scalar(const Traced& traced, const Segment& segment) noexcept;

// Whether a triangle of `which`, a bit for each of the leaf's, meets the segment.
bool meets_some(const HierarchyView& view, uint32_t leaf, uint32_t which, const Segment& segment) noexcept;

}  // namespace vcd
