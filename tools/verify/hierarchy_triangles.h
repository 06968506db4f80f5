// Whether a hierarchy is of its mesh.
#pragma once

#include <string>

#include <vcd/baker/prepare.h>
#include <vcd/format/hierarchy.h>

#include <vcd/verify/outcome.h>

namespace vcd::verify {

// Every triangle of the mesh is in the hierarchy exactly once, its positions to the bit, and nothing else is. That
// boxes hold what is below them is check_hierarchy()'s to find: it must have passed this one as canonical.
void check_triangles(const HierarchyView& hierarchy, const baker::PreparedMesh& mesh, const std::string& place,
                     Outcome& outcome);

}  // namespace vcd::verify
