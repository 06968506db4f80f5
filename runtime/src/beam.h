// The beam from one point through a parallelogram: what decides for a bundle as a whole. See spec/design.md, "Bundles".
#pragma once

#include <vcd/format/line_cell.h>
#include <vcd/runtime/bundle.h>

namespace vcd {

// Corner lines that leave the box later along their parameter, which is 1 on the parallelogram, decide nothing.
inline constexpr float kFarthestExit = 2.0f;

// In the object's frame. All that follows `origin` is seen from there.
struct BeamFrame {
  bool usable;  // false: only the segments' own arrays of floats count
  float origin[3];
  float corner[3], edge_u[3], edge_v[3];  // the parallelogram that all segments pass through
  // For spheres: a direction d passes it at u = (d · to_u) / (d · axis) + 1/2, and v likewise.
  float axis[3], to_u[3], to_v[3];
  double reach;  // segments end at most so many times as far away as the parallelogram
};

BeamFrame beam_frame(const GridFrame& frame, const QuadBundle& bundle);
BeamFrame beam_frame(const GridFrame& frame, const SphereBundle& bundle);

// True only if no segment through u, v within these ranges meets the object.
bool misses(const GridFrame& frame, const BeamFrame& beam, const float u[2], const float v[2]);

}  // namespace vcd
