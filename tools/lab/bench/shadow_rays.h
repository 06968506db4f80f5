// The shadow rays of a plain picture: an object on the ground under a square light.
#pragma once

#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/format/segment.h>
#include <vcd/runtime/bundle.h>

namespace vcd::bench {

inline constexpr size_t kLightSamples = 128;

// Bundles, and all their segments one after the other.
struct LightBundles {
  std::vector<float> u, v;
  std::vector<QuadBundle> bundles;  // point into u and v: moving this is fine, copying it is not
  std::vector<Segment> segments;

  LightBundles() = default;
  LightBundles(LightBundles&&) = default;
};

// Segments from ground points to points of a square light above, stratified over the light. The ground lies just below
// the padded box and reaches half a box from its middle to one side and one and a half to the other, where the shadow
// falls; the light hangs one and a half boxes above, to the first side, and is 0.6 of the box wide. A box is as wide as
// the longest side. All coordinates in the object's frame, y up.
LightBundles shadow_rays(const baker::PreparedMesh& mesh, size_t points, uint64_t seed);

// Segments that all pierce the box: from points around the object, three boxes away, bundles of `samples` through a
// patch of a tenth of the box about a random point inside, and on to the other side. Neighbours fall into neighbouring
// cells.
std::vector<Segment> piercing_bundles(const baker::PreparedMesh& mesh, size_t bundles, size_t samples, uint64_t seed);

}  // namespace vcd::bench
