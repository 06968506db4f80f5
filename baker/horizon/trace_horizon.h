// The horizon of one side of a triangle, over the whole mesh.
#pragma once

#include <vcd/format/hierarchy.h>

#include "horizon/viewpoint.h"

namespace vcd::baker {

// A triangle of a hierarchy: its leaf, as a child's word, and its number in it.
struct InLeaf {
  uint32_t leaf = 0, triangle = 0;
  bool operator==(const InLeaf&) const = default;
};
Triangle corners_at(const HierarchyView& hierarchy, const InLeaf& at);

// By sector the triangle that set its slope; leaf 0: none. They are tried first for the next triangle beside, which
// changes no slope, but what is looked at for it.
using Setters = std::array<InLeaf, kHorizonSectors>;

Levels trace_horizon(const HierarchyView& hierarchy, const Viewpoint& from, Setters& setters);

}  // namespace vcd::baker
