// What a scene asks of its objects, told from its lights alone: no camera, no renderer.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <vcd/baker/prepare.h>
#include <vcd/baker/scene_light.h>
#include <vcd/format/demand.h>
#include <vcd/format/error.h>

namespace vcd::library {

struct LitInstance {
  const baker::PreparedMesh* mesh;
  std::array<double, 12> to_scene = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  // row-major 3 × 4
};

enum class Axis : uint32_t { x, y, z };

inline constexpr size_t kLightSegments = size_t{1} << 20;

// About so many segments to random points of the lights: half of them from the ground where the shadow of an object can
// fall, an object after the other; and half from surfaces, evenly by area. The ground is the plane below all objects;
// shadows count up to the size of the scene from it. Of the object that a segment starts on nothing is asked. The same
// arguments give the same demand.
//
// Empty if no light reaches anything. Errors: runtime (out of memory).
// up  points away from the ground
Result<Demand> demand_of_lights(std::span<const LitInstance> instances, std::span<const baker::SceneLight> lights,
                                Axis up = Axis::y, size_t segments = kLightSegments);

// Of one mesh on the ground, lit by the whole sky.
Result<Demand> demand_from_above(const baker::PreparedMesh& mesh, Axis up, size_t segments = kLightSegments);

}  // namespace vcd::library
