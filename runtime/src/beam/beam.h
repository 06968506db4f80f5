// The beam from one point through a parallelogram: what decides for a bundle as a whole. See spec/proofs.md, "Bundles".
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <vcd/format/line_cell.h>
#include <vcd/runtime/bundle.h>

#include "lookup/sample_bits.h"

namespace vcd {

// Corner lines that leave the box later along their parameter, which is 1 on the parallelogram, decide nothing.
inline constexpr float kFarthestExit = 2.0f;

// In the bundle's frame. All that follows `origin` is seen from there.
struct BeamFrame {
  bool usable;  // false: only the segments' own arrays of floats count
  float origin[3];
  float corner[3], edge_u[3], edge_v[3];  // the parallelogram that all segments pass through
  // For spheres: a direction d passes it at u = (d · to_u) / (d · axis) + 1/2, and v likewise.
  float axis[3], to_u[3], to_v[3];
  double reach;    // segments end at most so many times as far away as the parallelogram
  float rounding;  // directions are within 3 rounding · 2^-24 of BundleChunk::size of what u and v say of them
};

// What callers of a bundle's queries must see to: samples of one size, room for the answers.
inline bool fits(const QuadBundle& b, std::span<const uint64_t> bits) {
  return b.u.size() == b.v.size() && has_words_for(b.size(), bits);
}
template <class Bundle>  // with x, y and z
bool fits(const Bundle& b, std::span<const uint64_t> bits) {
  return b.x.size() == b.y.size() && b.x.size() == b.z.size() && has_words_for(b.size(), bits);
}

BeamFrame beam_frame(const QuadBundle& bundle);
BeamFrame beam_frame(const SphereBundle& bundle);  // not usable from in or close to the sphere

// The least and the greatest of some floats. Both are NaN if one of them is.
struct Extent {
  float low, high;
  static constexpr Extent nan() {
    return {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::quiet_NaN()};
  }
  float most() const { return std::max(std::abs(low), std::abs(high)); }
};

// Some of a bundle's samples, by their place on the parallelogram.
struct BundleChunk {
  size_t first, count;        // first: a multiple of kChunk
  const float *u, *v;         // count of them, and the last again up to a whole run
  Extent u_extent, v_extent;  // measured by a kernel
  // How large the numbers are, on each axis, of which the directions are made: at least those of the whole
  // parallelogram, of which a sphere's u and v are made. Not finite if a direction is not.
  float size[3];
  alignas(64) float own_u[kChunk], own_v[kChunk];

  size_t runs() const { return (count + kRun - 1) / kRun; }
  // The bits of a run's samples that are not padding.
  uint64_t real(size_t r) const { return (uint64_t{1} << (r + 1 < runs() ? kRun : count - r * kRun)) - 1; }
};
void place(const QuadBundle& bundle, const BeamFrame& frame, BundleChunk& chunk);
void place(const SphereBundle& bundle, const BeamFrame& frame, BundleChunk& chunk);

// Once the extents are measured.
inline void set_size(const BeamFrame& beam, BundleChunk& chunk) {
  const float u = std::max(chunk.u_extent.most(), 1.0f), v = std::max(chunk.v_extent.most(), 1.0f);
  for (int a = 0; a < 3; ++a)
    chunk.size[a] = std::abs(beam.corner[a]) + u * std::abs(beam.edge_u[a]) + v * std::abs(beam.edge_v[a]);
}

// Whether rounding in this object's grid stays well below the guard band. False if anything is not finite.
bool near_enough(const GridFrame& frame, const BeamFrame& beam, const BundleChunk& chunk);

// Whether the beam is so narrow that its lines often have a cell or some equal ones in common. Of wider ones that is
// rarely so, and to find out costs as much as to look up some of their lines.
bool is_narrow(const BeamFrame& beam, const BundleChunk& chunk);

// True only if none of the segments meets the object, which is near enough.
bool misses(const GridFrame& frame, const BeamFrame& beam, const BundleChunk& chunk);

}  // namespace vcd
