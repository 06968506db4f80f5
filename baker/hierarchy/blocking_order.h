// Fourth pass of the hierarchy's build: the order in which a node's children are visited.
#pragma once

#include "hierarchy/stop.h"
#include "hierarchy/wide_tree.h"

namespace vcd::baker {

// Puts first what is likely to block and cheap to visit, since a query ends at the first hit: the measured probability
// that a ray which meets a child's box is blocked below it, over the mean number of nodes and leaves that this takes in
// the order that was there before (a second round in the new order gains nothing).
// (Ize and Hansen, "RTSAH traversal order for occlusion rays", 2011; Nah and Manocha, "SATO: surface area traversal
// order for shadow ray tracing", 2014; Ogaki and Derouet-Jourdan, "An N-ary BVH child node sorting technique for
// occlusion tests", 2016.) Measured with SampleRays. Unfinished, but a tree all the same, if it was stopped.
//
// box: of the mesh.
void order_children(const PreparedMesh& mesh, WideTree& tree, const Bounds& box, Stop& stop);

}  // namespace vcd::baker
