// Scenes as glTF 2.0, for any program that reads it.
#pragma once

#include <cstddef>
#include <vector>

#include <vcd/scenes/scene.h>

namespace vcd::scenes {

// A whole .glb file: one glTF mesh a mesh (with a diffuse material of its colour), one node an instance, the camera,
// and the lights in the `extras` of nodes (spec/demand.md). The ground is left out. Positions keep every bit.
// Every mesh must have a triangle (else std::invalid_argument). Throws std::length_error where the file would exceed
// the 4 GiB that GLB allows.
std::vector<std::byte> to_glb(const Scene& scene);

}  // namespace vcd::scenes
