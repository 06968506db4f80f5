// The rays with which the order of children is measured.
#pragma once

#include <cstdint>
#include <vector>

#include <vcd/baker/prepare.h>

#include "hierarchy/bounds.h"

namespace vcd::baker {

// A segment in the form that boxes and triangles are tested in. Its direction is such that the mesh is some units of t
// long.
struct SampleRay {
  float origin[3], reciprocal[3];  // of the direction; no component is 0
  float t_min, t_max;
  // Woop, Benthin and Wald, "Watertight ray/triangle intersection", 2013: the frame in which the ray is the z axis.
  uint32_t x, y, z;  // axes
  float shear_x, shear_y, scale_z;
};

// Rays of one mesh, by number. The same geometry has the same rays. Safe from any thread.
class SampleRays {
 public:
  SampleRays(const PreparedMesh& mesh, const Bounds& box);

  // Even numbers: an isotropic line through a point of the box, from before it to behind it. Odd numbers: from a point
  // of the surface to one side, more often near the normal (by the cosine), as light falls on it.
  SampleRay operator()(uint32_t number) const;

 private:
  const PreparedMesh& mesh_;
  const Bounds box_;
  double length_;                   // of the box's diagonal
  uint64_t seed_;                   // from the geometry hash
  std::vector<double> area_up_to_;  // of the triangles up to each one
};

}  // namespace vcd::baker
