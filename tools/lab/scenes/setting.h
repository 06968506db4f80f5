// The paper's setting about objects of any size: a ground, two square lights above, and a camera that sees it all.
#pragma once

#include <vcd/scenes/scene.h>

#include "vec.h"

namespace vcd::scenes {

struct Box {
  Double3 low, high;
};

Box bounds(const Scene& scene);  // of all instances, in the world; about the origin if there is none

// From where the camera looks at an object.
struct View {
  double turn = 0.07;        // about y, in turns: 0 is from the front (+z), to the right if positive
  double elevation = 0.066;  // above the horizon, in turns
  double fill = 0.74;        // how much of the picture the object may take, across or along
};

// Sets ground, lights and camera from what the instances occupy: the ground at the lowest point, exactly.
void put_in_setting(Scene& scene, const View& view = {});

// A horizontal square that shines down from above `center`. `reflected` is the radiance that a white ground at
// `lit` would send back if this light were alone, by the light's centre: L · A · cos² / (π r²).
AreaLight square_light(Double3 center, double side, Double3 lit, Double3 reflected);

}  // namespace vcd::scenes
