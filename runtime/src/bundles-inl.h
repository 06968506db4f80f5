// Bundles: segments from one point to one light, as beams where their cells agree.
#if defined(VCD_RUNTIME_BUNDLES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_BUNDLES_INL_H
#undef VCD_RUNTIME_BUNDLES_INL_H
#else
#define VCD_RUNTIME_BUNDLES_INL_H
#endif

#include <cmath>

#include <vcd/runtime/bundle.h>

#include "beam.h"
#include "bits.h"
#include "lanes-inl.h"
#include "range_class.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

// Samples of a chunk of a bundle, by their place on the light: sixteen are a run, and decided as one where possible.
constexpr size_t kRun = 16, kBundleChunk = 256, kRuns = kBundleChunk / kRun;
static_assert(kRun % kWidth == 0 && kChunk % kRun == 0);

struct ChunkOfBundle {
  size_t first, count;
  HWY_ALIGN float u[kBundleChunk], v[kBundleChunk];  // the last sample again up to a whole run
};

HWY_INLINE void pad(ChunkOfBundle& chunk) {
  for (size_t i = chunk.count; i % kRun != 0; ++i) chunk.u[i] = chunk.u[chunk.count - 1], chunk.v[i] = chunk.v[chunk.count - 1];
}

HWY_INLINE void place(const QuadBundle& bundle, const BeamFrame&, ChunkOfBundle& chunk) {
  std::copy_n(bundle.u.data() + chunk.first, chunk.count, chunk.u);
  std::copy_n(bundle.v.data() + chunk.first, chunk.count, chunk.v);
  pad(chunk);
}
// Where the segments cross the square before the sphere.
HWY_INLINE void place(const SphereBundle& bundle, const BeamFrame& frame, ChunkOfBundle& chunk) {
  for (size_t i = 0; i < chunk.count; ++i) {
    const size_t at = chunk.first + i;
    const float d[3] = {bundle.x[at] - bundle.origin[0], bundle.y[at] - bundle.origin[1], bundle.z[at] - bundle.origin[2]};
    const auto along = [&](const float(&n)[3]) { return d[0] * n[0] + d[1] * n[1] + d[2] * n[2]; };
    const float scale = 1.0f / along(frame.axis);
    chunk.u[i] = along(frame.to_u) * scale + 0.5f;
    chunk.v[i] = along(frame.to_v) * scale + 0.5f;
  }
  pad(chunk);
}

// Segments of one run, a group of kWidth of them.
HWY_INLINE Lanes group_of(const QuadBundle&, const BeamFrame& frame, const ChunkOfBundle& chunk, size_t at) {
  const Floats u = hn::Load(F(), chunk.u + at), v = hn::Load(F(), chunk.v + at);
  Lanes lanes;
  for (int a = 0; a < 3; ++a) {
    lanes.origin[a] = all(frame.origin[a]);
    lanes.direction[a] = hn::Add(hn::Add(all(frame.corner[a]), hn::Mul(u, all(frame.edge_u[a]))), hn::Mul(v, all(frame.edge_v[a])));
  }
  lanes.t_min = hn::Zero(F());
  lanes.t_max = all(1.0f);
  return lanes;
}
HWY_INLINE Lanes group_of(const SphereBundle& bundle, const BeamFrame&, const ChunkOfBundle& chunk, size_t at) {
  HWY_ALIGN float target[3][kWidth];
  for (size_t k = 0; k < kWidth; ++k) {
    const size_t i = chunk.first + std::min(at + k, chunk.count - 1);
    target[0][k] = bundle.x[i], target[1][k] = bundle.y[i], target[2][k] = bundle.z[i];
  }
  Lanes lanes;
  for (int a = 0; a < 3; ++a) {
    lanes.origin[a] = all(bundle.origin[a]);
    lanes.direction[a] = hn::Sub(hn::Load(F(), target[a]), lanes.origin[a]);
  }
  lanes.t_min = hn::Zero(F());
  lanes.t_max = all(1.0f);
  return lanes;
}

// The four corner lines of each run's rectangle on the light.
struct Corners {
  HWY_ALIGN uint32_t stuv[4 * kRuns], route[4 * kRuns];  // route: pair and whether swapped; kNoRoute: not to be used
  HWY_ALIGN uint32_t pierces[4 * kRuns];
};
constexpr uint32_t kNoRoute = 0xFF;

HWY_INLINE void locate_corners(const ObjectData& data, const BeamFrame& frame, const float* u, const float* v, size_t count, Corners& corners) {
  for (size_t at = 0; at < count; at += kWidth) {
    const Floats cu = hn::Load(F(), u + at), cv = hn::Load(F(), v + at);
    Lanes lanes;
    for (int a = 0; a < 3; ++a) {
      lanes.origin[a] = all(frame.origin[a]);
      lanes.direction[a] = hn::Add(hn::Add(all(frame.corner[a]), hn::Mul(cu, all(frame.edge_u[a]))), hn::Mul(cv, all(frame.edge_v[a])));
    }
    const Lines lines = locate_lines(data.frame, lanes);
    const Truth usable = hn::And(hn::And(lines.valid, hn::Lt(lines.entry, lines.exit)),
                                 hn::And(hn::Gt(lines.entry, hn::Zero(F())), hn::Le(lines.exit, all(kFarthestExit))));
    const Words route = hn::Or(hn::ShiftLeft<1>(lines.pair), hn::IfThenElseZero(hn::RebindMask(U(), lines.swapped), all(1u)));
    hn::Store(hn::IfThenElse(hn::RebindMask(U(), usable), route, all(kNoRoute)), U(), corners.route + at);
    hn::Store(lines.stuv, U(), corners.stuv + at);
    hn::Store(hn::IfThenElseZero(hn::RebindMask(U(), hn::Le(lines.exit, all(1.0f))), all(1u)), U(), corners.pierces + at);
  }
}

// What all lines between these corner lines have in common.
HWY_INLINE Visibility beam_class(const ObjectData& data, const Corners& corners, size_t first, size_t count) {
  const uint32_t route = corners.route[first];
  if (route == kNoRoute) return Visibility::unclassified;
  uint32_t low[4] = {255, 255, 255, 255}, high[4] = {}, pierces = 1;
  for (size_t i = first; i < first + count; ++i) {
    if (corners.route[i] != route) return Visibility::unclassified;
    pierces &= corners.pierces[i];
    for (int d = 0; d < 4; ++d) {
      const uint32_t x = corners.stuv[i] >> (24 - 8 * d) & 255;
      low[d] = std::min(low[d], x), high[d] = std::max(high[d], x);
    }
  }
  CellRange range{route >> 1, {}, {}};
  const uint32_t up = 8 - data.tree.shape.levels;
  for (int d = 0; d < 4; ++d) range.low[d] = low[d] >> up, range.high[d] = high[d] >> up;
  const Visibility found = range_class(data.tree, range);
  return found == Visibility::blocked && !pierces ? Visibility::unclassified : found;
}

template <uint32_t kDepth, class Bundle>
HWY_INLINE void classify_chunk_of(const ObjectData& data, const Bundle& bundle, const BeamFrame& frame, const ChunkOfBundle& chunk,
                                  uint64_t* blocked, uint64_t* open) {
  const size_t runs = (chunk.count + kRun - 1) / kRun;
  const auto in_run = [&](size_t r) { return std::min(kRun, chunk.count - r * kRun); };
  const auto block_run = [&](size_t r) { blocked[(chunk.first + r * kRun) / 64] |= bits_from(chunk.first + r * kRun, in_run(r)); };
  size_t undecided[kRuns], count = 0;
  if (frame.usable) {
    HWY_ALIGN float u[4 * kRuns], v[4 * kRuns];
    float u_range[2], v_range[2];
    for (size_t r = 0; r < runs; ++r) {
      const auto [u0, u1] = std::minmax_element(chunk.u + r * kRun, chunk.u + (r + 1) * kRun);
      const auto [v0, v1] = std::minmax_element(chunk.v + r * kRun, chunk.v + (r + 1) * kRun);
      for (size_t c = 0; c < 4; ++c) u[4 * r + c] = c & 1 ? *u1 : *u0, v[4 * r + c] = c & 2 ? *v1 : *v0;
      u_range[0] = r == 0 ? *u0 : std::min(u_range[0], *u0), u_range[1] = r == 0 ? *u1 : std::max(u_range[1], *u1);
      v_range[0] = r == 0 ? *v0 : std::min(v_range[0], *v0), v_range[1] = r == 0 ? *v1 : std::max(v_range[1], *v1);
    }
    if (misses(data.frame, frame, u_range, v_range)) return;
    for (size_t i = 4 * runs; i % kWidth != 0; ++i) u[i] = u[0], v[i] = v[0];
    Corners corners;
    locate_corners(data, frame, u, v, (4 * runs + kWidth - 1) / kWidth * kWidth, corners);
    const Visibility whole = beam_class(data, corners, 0, 4 * runs);
    if (whole == Visibility::clear) return;
    for (size_t r = 0; r < runs; ++r) {
      const Visibility found = whole == Visibility::blocked ? whole : beam_class(data, corners, 4 * r, 4);
      if (found == Visibility::blocked) block_run(r);
      if (found == Visibility::unclassified) undecided[count++] = r;
    }
  } else {
    for (size_t r = 0; r < runs; ++r) undecided[count++] = r;
  }
  constexpr size_t kRunsAtOnce = kChunk / kRun, kGroups = kRun / kWidth;
  for (size_t first = 0; first < count; first += kRunsAtOnce) {
    const size_t some = std::min(kRunsAtOnce, count - first);
    Visibility answers[kChunk];
    classify_chunk<kDepth>(data, some * kGroups, [&](size_t g) HWY_ATTR {
      return group_of(bundle, frame, chunk, undecided[first + g / kGroups] * kRun + g % kGroups * kWidth);
    }, answers);
    for (size_t k = 0; k < some; ++k)
      for (size_t i = 0; i < in_run(undecided[first + k]); ++i)
        set_bits(answers[k * kRun + i], chunk.first + undecided[first + k] * kRun + i, blocked, open);
  }
}

template <uint32_t kDepth, class Bundle>
void ClassifyBundleOf(const ObjectData& data, const Bundle& bundle, uint64_t* blocked, uint64_t* open) {
  clear_bits(bundle.size(), blocked, open);
  const BeamFrame frame = beam_frame(data.frame, bundle);
  ChunkOfBundle chunk;
  for (chunk.first = 0; chunk.first < bundle.size(); chunk.first += kBundleChunk) {
    chunk.count = std::min(kBundleChunk, bundle.size() - chunk.first);
    place(bundle, frame, chunk);
    classify_chunk_of<kDepth>(data, bundle, frame, chunk, blocked, open);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
