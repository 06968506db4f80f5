// Private to the trees: what all species are made of.
#pragma once

#include <vcd/scenes/scene.h>

#include "vec.h"

namespace vcd::scenes {

struct Leaf {
  Double3 base, along, across;  // unit vectors along the midrib and across it
  double length, width;
  double fold;  // how far the two halves are raised out of the plane, as a part of the width
};

inline void append_leaf(Mesh& mesh, const Leaf& leaf) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  const Double3 lifted = (leaf.fold * leaf.width) * cross(leaf.along, leaf.across);
  const Double3 middle = leaf.base + (0.45 * leaf.length) * leaf.along + lifted;
  const Double3 half = (0.5 * leaf.width) * leaf.across;
  for (const Double3& p : {leaf.base, middle - half, leaf.base + leaf.length * leaf.along, middle + half})
    mesh.positions.push_back(on_grid(p));
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

inline uint32_t sides_for(double radius) { return radius > 0.06 ? 9 : radius > 0.02 ? 6 : radius > 0.01 ? 4 : 3; }

void grow_conifer(Mesh& mesh, uint32_t leaves, double leaf_scale, Random& random);
uint64_t conifer_triangles_bound(uint32_t leaves);

}  // namespace vcd::scenes
