// Where an instance stands: from the world to its grid, and its box in the world.
#pragma once

#include <optional>

#include <vcd/runtime/scene.h>

#include "lookup/to_grid.h"

namespace vcd {

struct Placed {
  ToGrid to_grid;
  float low[3], high[3];  // its box in the world
};

// Nothing if the transform cannot be used.
std::optional<Placed> place(const SceneInstance& instance, const Transform& to_world);

// Room between the mesh and the box, as bakers leave it: what a line does that touches the box is then no matter of
// rounding.
void pad_box(SceneInstance& instance);

}  // namespace vcd
