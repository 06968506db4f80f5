#include "scene/beams.h"

#include <algorithm>
#include <cmath>

#include "scene/trusted.h"

namespace vcd {

bool is_trusted(const BeamFrame& frame, const BundleChunk& chunk) {
  bool near = true;
  for (int a = 0; a < 3; ++a)
    near &= std::abs(frame.origin[a]) <= kFarthest && chunk.size[a] * frame.rounding <= 0.5f * kFarthest;
  return near;
}

SceneBeam beam_of(const BeamFrame& frame, const BundleChunk& chunk) {
  const Extent u = chunk.u_extent, v = chunk.v_extent;
  SceneBeam beam;
  for (int a = 0; a < 3; ++a) {
    const float ends[4] = {u.low * frame.edge_u[a], u.high * frame.edge_u[a], v.low * frame.edge_v[a],
                           v.high * frame.edge_v[a]};
    // Rounding of the directions, and of u and v where they were computed.
    const float slack = kBoxSlack * frame.rounding * chunk.size[a];
    beam.origin_low[a] = beam.origin_high[a] = frame.origin[a];
    beam.inverse_low[a] = inverse_of(frame.corner[a] + std::min(ends[0], ends[1]) + std::min(ends[2], ends[3]) - slack);
    beam.inverse_high[a] =
        inverse_of(frame.corner[a] + std::max(ends[0], ends[1]) + std::max(ends[2], ends[3]) + slack);
  }
  beam.t_max = static_cast<float>(frame.reach) * (1 + kBoxSlack);
  return beam;
}

bool near_enough(const ToGrid& grid, const BeamFrame& frame, const BundleChunk& chunk) {
  float sum = 0;
  for (int a = 0; a < 3; ++a) sum += grid.column[a][3] * chunk.size[a];
  return sum * frame.rounding * static_cast<float>(frame.reach) <= kFarthestReach;
}

std::optional<SceneBeam> beam_of(const SegmentColumns<kChunk>& columns, size_t first, size_t count) {
  SceneBeam beam;
  float spread = 0, length = 0, origin_spread = 0, t_min = columns.t_min[first];
  beam.t_max = columns.t_max[first];
  for (size_t i = first; i < first + count; ++i)
    t_min = std::min(t_min, columns.t_min[i]), beam.t_max = std::max(beam.t_max, columns.t_max[i]);
  for (int a = 0; a < 3; ++a) {
    const float *o = columns.origin[a] + first, *d = columns.direction[a] + first;
    float o_low = o[0], o_high = o[0], d_low = d[0], d_high = d[0];
    for (size_t i = 0; i < count; ++i) {
      o_low = std::min(o_low, o[i]), o_high = std::max(o_high, o[i]);
      d_low = std::min(d_low, d[i]), d_high = std::max(d_high, d[i]);
    }
    beam.origin_low[a] = o_low, beam.origin_high[a] = o_high;
    beam.inverse_low[a] = inverse_of(d_low), beam.inverse_high[a] = inverse_of(d_high);
    spread += d_high - d_low, length += std::max(std::abs(d_low), std::abs(d_high)), origin_spread += o_high - o_low;
  }
  constexpr float kCoherent = 0.25f;
  const bool coherent = spread <= kCoherent * length && origin_spread <= kCoherent * length * beam.t_max;
  if (!(t_min >= 0 && coherent)) return std::nullopt;
  return beam;
}

}  // namespace vcd
