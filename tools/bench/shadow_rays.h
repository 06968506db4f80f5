// The shadow rays of a plain picture: an object on the ground under a square light.
#pragma once

#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/format/segment.h>

namespace vcd {

// Segments from ground points to points of a square light above, `samples` of each ground point one after the other,
// stratified over the light. The ground lies just below the padded box and reaches two boxes to each side; the light
// hangs two boxes above, to one side, and is 0.6 of the box wide. All coordinates in the object's frame, y up.
std::vector<Segment> shadow_rays(const PreparedMesh& mesh, size_t points, size_t samples, uint64_t seed);

}  // namespace vcd
