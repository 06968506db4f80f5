// Where an instance stands: from the world to its grid, and its box in the world.
#pragma once

#include <vcd/runtime/scene.h>

#include "lookup/to_grid.h"

namespace vcd {

struct Placed {
  ToGrid to_grid;         // kNoInverse: the transform has no inverse that floats can hold
  float low[3], high[3];  // its box in the world: infinite if it cannot be boxed, empty if the instance is absent
  float middle[3];        // of that box, or 0
  bool absent;            // it has no extent in the world
};

// Any floats are allowed.
Placed place(const SceneInstance& instance, const Transform& to_world);

// Room between the mesh and the box, as bakers leave it: what a line does that touches the box is then no matter of
// rounding. Empty boxes stay empty.
void pad_box(SceneInstance& instance);

}  // namespace vcd
