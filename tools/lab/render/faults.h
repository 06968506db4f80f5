// What makes a picture say nothing, or not what it seems to say.
#pragma once

#include <string>
#include <vector>

#include "renderer.h"
#include "world.h"

namespace vcd::render {

// A sentence each, for a person: an object so far from the origin of its frame that the rounding of 32-bit floats is
// seen; nothing, or next to nothing, of any object in the picture, and why; pixels that are not finite.
std::vector<std::string> faults_of(const World& world, const RenderSettings& settings, const Rendered& rendered);

}  // namespace vcd::render
