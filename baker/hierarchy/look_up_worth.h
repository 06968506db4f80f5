// Whether look-ups before a hierarchy save time.
#pragma once

#include <cstdint>

#include <vcd/baker/prepare.h>
#include <vcd/format/hierarchy.h>
#include <vcd/format/layout.h>
#include <vcd/format/tree.h>

namespace vcd::baker {

// kLookUpFromOutside and kLookUpFromInside, where they hold. Counted, not timed, so that the same bake gives the same
// flags: the nodes and leaves that some thousand segments take through the hierarchy, against those that are left when
// look-ups answer what they can, and what a look-up costs beside a node.
uint16_t look_up_worth(const PreparedMesh& mesh, const ObjectRecord& record, const TreeView& tree,
                       const HierarchyView& hierarchy);

}  // namespace vcd::baker
