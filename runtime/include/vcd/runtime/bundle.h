// Segments from one point to the samples of one light.
//
// A bundle is decided as a whole where it can be: if all cells of the tree that its lines pass through agree, no line
// is looked up by itself (beams: Billen and Dutré 2016 give the line space; the argument is in spec/proofs.md,
// "Bundles"). What is decided so is what single look-ups would say, or more where these say nothing: within rounding of
// a cell's border, and of segments too short or too long to be looked up, which are clear where all that are decided
// with them miss the box. Segments that are not finite are unclassified, as alone, and nothing to their neighbours.
#pragma once

#include <concepts>
#include <cstddef>
#include <span>

#include <vcd/format/segment.h>

namespace vcd {

// Sample i is corner + u[i] · edge_u + v[i] · edge_v, in the object's frame; its segment runs from origin to it, both
// ends excluded. u and v are of one size. Neighbours in the arrays should be neighbours on the light, sixteen at a
// time. Promises hold for every segment from the origin to a point within 2^-15 of the box's extents of the sample.
struct QuadBundle {
  float origin[3];
  float corner[3], edge_u[3], edge_v[3];
  std::span<const float> u, v;
  size_t size() const { return u.size(); }
};

// Samples in or on a sphere, {x[i], y[i], z[i]} in the object's frame; x, y and z are of one size. (A sample that is
// not there may get any answer.)
struct SphereBundle {
  float origin[3];
  float centre[3], radius;
  std::span<const float> x, y, z;
  size_t size() const { return x.size(); }
};

// Segments from one point to any others: sample i is origin + {x[i], y[i], z[i]}. Samples of several lights, of a disk,
// a triangle, or a sky (directions times a length beyond all objects). Neighbours in the arrays should be near to each
// other, as seen from the origin, a few hundred at a time.
struct PointBundle {
  float origin[3];
  std::span<const float> x, y, z;
  size_t size() const { return x.size(); }
};

// Along one axis, from the origin to sample i.
inline float direction_of(const QuadBundle& b, size_t i, size_t axis) {
  return ((b.corner[axis] - b.origin[axis]) + b.u[i] * b.edge_u[axis]) + b.v[i] * b.edge_v[axis];
}
inline float direction_of(const SphereBundle& b, size_t i, size_t axis) {
  const std::span<const float> at[3] = {b.x, b.y, b.z};
  return at[axis][i] - b.origin[axis];
}
inline float direction_of(const PointBundle& b, size_t i, size_t axis) {
  const std::span<const float> at[3] = {b.x, b.y, b.z};
  return at[axis][i];
}

// One of its segments.
template <class Bundle>
requires std::same_as<Bundle, QuadBundle> || std::same_as<Bundle, SphereBundle> || std::same_as<Bundle, PointBundle>
    Segment segment_of(const Bundle& b, size_t i) {
  return {{b.origin[0], b.origin[1], b.origin[2]},
          0.0f,
          {direction_of(b, i, 0), direction_of(b, i, 1), direction_of(b, i, 2)},
          1.0f};
}

}  // namespace vcd
