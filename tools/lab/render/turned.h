// The camera and the lights of a world, moved about it.
#pragma once

#include <vector>

#include "world.h"

namespace vcd::render {

// By so many degrees about the upright axis through the middle of all that casts shadows.
View turned_view(const World& world, double degrees);
std::vector<Light> turned_lights(const World& world, double degrees);

}  // namespace vcd::render
