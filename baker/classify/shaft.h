// The shaft of a line cell: the convex hull of its two squares, grown by the guard band.
#pragma once

#include <array>
#include <cstdint>

#include <vcd/baker/cell.h>

namespace vcd::baker {

inline constexpr uint32_t kShaftPlanes = 12;  // used; the arrays hold sixteen
inline constexpr uint32_t kLanes = 16;

// Points x with normal · x ≤ offset for all planes, in grid units. It holds every segment between the two squares, each
// grown in all three directions by kGuardBand + kProofSlack; so whatever a proof leaves out of it by rounding is within
// the slack. The squares grown are axis-parallel boxes, and each facet of the hull of two such boxes contains an axis
// direction (Haines and Wallace 1991): planes of the bounding box, and in each of the three projections the slanted
// edges of the hull of two rectangles. Normals have an L1 norm of 1, so a point that is off by ε in each coordinate has
// distances that are off by at most ε.
struct alignas(64) Shaft {
  float normal[3][kLanes];  // lanes from `planes` on: 0
  float offset[kLanes];     // likewise: 1, so that every point is inside
  uint32_t planes;
};

Shaft make_shaft(const Cell& cell);

// How far, in grid units, what line → cell computes may be from the line that was asked, by proof: spec/proofs.md,
// "The guard band".
inline constexpr float kGuardBand = 0.05f;
// What the floating-point arithmetic of the proofs may lose: likewise.
inline constexpr float kProofSlack = 0x1p-10f;

// The squares of a cell as boxes of no thickness, low face's first.
struct Square {
  std::array<double, 3> min, max;
};
std::array<Square, 2> squares(const Cell& cell);

}  // namespace vcd::baker
