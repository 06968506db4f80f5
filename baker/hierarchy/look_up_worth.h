// Whether look-ups before a hierarchy save time.
#pragma once

#include <cstdint>
#include <span>

#include <vcd/baker/prepare.h>
#include <vcd/format/demand.h>
#include <vcd/format/hierarchy.h>
#include <vcd/format/layout.h>
#include <vcd/format/tree.h>

namespace vcd::baker {

// The flags kLookUp… of ObjectRecord that hold. Counted, not timed, so that the same bake gives the same flags: the
// nodes and leaves that some thousand segments take through the hierarchy, against those that are left when look-ups
// answer what they can, and what a look-up costs beside a node. asked: what a scene asks of the object; empty: lines
// from everywhere stand for it.
uint16_t look_up_worth(const PreparedMesh& mesh, const ObjectRecord& record, const TreeView& tree,
                       const HierarchyView& hierarchy, std::span<const AskedSegment> asked = {});

}  // namespace vcd::baker
