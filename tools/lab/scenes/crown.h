// Branching by space colonization: Runions, Lane and Prusinkiewicz, Modeling Trees with a Space Colonization Algorithm,
// 2007. Points scattered over the crown's volume draw the branches that are nearest to them, and vanish when reached.
#pragma once

#include <vector>

#include "vec.h"

namespace vcd::scenes {

struct BranchNode {
  Double3 at;
  uint32_t parent;        // comes before its children; a root is its own parent
  double radius = 0;      // of the branch from here outwards
  uint32_t thickest = 0;  // the child that carries the branch on; itself at a tip
};

struct CrownShape {
  double height, crown_base, crown_radius;  // metres
  double (*profile)(double);  // of the crown: at a height of 0 … 1 within it, its radius as a part of crown_radius
  uint32_t stems;             // trunks that rise from the root
  double stem_spread;         // how far from upright they stand, in turns
  double rise;                // how strongly branches turn upwards; below 0, downwards
  double tip_radius;  // of the thinnest twigs; a branch's cross-section is the sum of its twigs' (Leonardo's rule)
  double step;        // length of a branch segment
};

// At most 4 nodes for a point and 64 more.
std::vector<BranchNode> grow_crown(const CrownShape& shape, uint32_t points, Random& random);

}  // namespace vcd::scenes
