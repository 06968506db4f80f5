// Rays of a cell that pass just beside the edges at which a surface turns away or ends: if a cell has gaps, there.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <embree3/rtcore.h>

#include <vcd/baker/cell.h>

#include "classify/sheet.h"
#include "classify/triangle_groups.h"

namespace vcd::baker {

// An edge of a silhouette or boundary, or the part of it that is inside a shaft.
struct SilhouetteEdge {
  std::array<double, 3> from, to;
};

// Up to `most` edges that meet the shaft and bound the surface, or part a triangle that faces along the cell's middle
// line from one that faces against it: one of a cluster, from clusters all over the shaft.
void silhouette_edges(const TriangleGroups& groups, const Surface& surface, const Cell& cell, const Shaft& shaft,
                      const Candidates& candidates, size_t most, std::vector<SilhouetteEdge>& into);

// Up to 16 rays of the cell, from its low square at tnear 0 to its high square at tfar 1, in pairs on either side of
// the first eight edges. Returns how many. The same cell and edges give the same rays.
uint32_t aim_rays(const Cell& cell, uint64_t seed, const std::vector<SilhouetteEdge>& edges, RTCRay16& rays);

}  // namespace vcd::baker
