// Where an instance stands: from the world to its grid, and the box that holds it in the world.
#pragma once

#include <vector>

#include <vcd/runtime/scene.h>

#include "hierarchy/traced.h"
#include "lookup/to_grid.h"

namespace vcd {

struct Placed {
  ToGrid to_grid;         // kNoInverse: the transform has no inverse that floats can hold
  float low[3], high[3];  // what holds it in the world: infinite if it cannot be boxed, empty if the instance is absent
  float middle[3];        // of that box, or 0
  bool absent;            // it has no extent in the world
};

// Boxes that hold an object's mesh together, in the object's own frame, each with as much room to the mesh as the
// record's box has. Turned with it, they reach less far than its one box does.
struct BoxList {
  std::vector<double> middle[3], half[3];  // half: of the extents
};
struct MeshBoxes {
  BoxList few, many;  // of the upper level of its hierarchy, and of the two upper levels
};
MeshBoxes mesh_boxes(const ObjectRecord& record, const Traced& traced);

// Any floats are allowed. boxes: null for an object without a hierarchy.
Placed place(const SceneInstance& instance, const MeshBoxes* boxes, const Transform& to_world);

struct WorldBox {
  float low[3], high[3];
};
// The few boxes of an instance, where it was placed by them.
std::vector<WorldBox> boxes_in_world(const Placed& placed, const MeshBoxes& boxes, const Transform& to_world);

// Room between the mesh and the box, as bakers leave it: what a line does that touches the box is then no matter of
// rounding. Empty boxes stay empty.
void pad_box(SceneInstance& instance);

}  // namespace vcd
