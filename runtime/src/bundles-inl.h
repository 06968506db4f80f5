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
#include "placed-inl.h"
#include "range_class.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

static_assert(kRun % kWidth == 0 && kChunk % kRun == 0);

// Directions of one run's segments.
HWY_INLINE void directions_of(const QuadBundle&, const BeamFrame& frame, const BundleChunk& chunk, size_t at, float* const (&into)[3]) {
  for (size_t i = 0; i < kRun; i += kWidth) {
    const Floats u = hn::LoadU(F(), chunk.u + at + i), v = hn::LoadU(F(), chunk.v + at + i);
    for (int a = 0; a < 3; ++a)
      hn::StoreU(hn::Add(hn::Add(all(frame.corner[a]), hn::Mul(u, all(frame.edge_u[a]))), hn::Mul(v, all(frame.edge_v[a]))), F(), into[a] + i);
  }
}
HWY_INLINE void directions_of(const SphereBundle& bundle, const BeamFrame&, const BundleChunk& chunk, size_t at, float* const (&into)[3]) {
  for (size_t k = 0; k < kRun; ++k) {
    const size_t i = chunk.first + std::min(at + k, chunk.count - 1);
    into[0][k] = bundle.x[i] - bundle.origin[0], into[1][k] = bundle.y[i] - bundle.origin[1], into[2][k] = bundle.z[i] - bundle.origin[2];
  }
}

// A few runs as arrays of segments, all from one point.
struct RunsAsArrays {
  static constexpr size_t kMost = kChunk / kRun;
  HWY_ALIGN float origin[3][kChunk], direction[3][kChunk], t_min[kChunk], t_max[kChunk];

  explicit RunsAsArrays(const float (&point)[3]) {
    for (int a = 0; a < 3; ++a) std::fill_n(origin[a], kChunk, point[a]);
    std::fill_n(t_min, kChunk, 0.0f);
    std::fill_n(t_max, kChunk, 1.0f);
  }
  SegmentArrays view(size_t runs) const {
    return {{origin[0], origin[1], origin[2]}, t_min, {direction[0], direction[1], direction[2]}, t_max, runs * kRun};
  }
};

// count: a multiple of kRun.
HWY_INLINE void bounds_of(const float* values, size_t count, float (&bounds)[2]) {
  Floats low = hn::LoadU(F(), values), high = low;
  for (size_t i = kWidth; i < count; i += kWidth) {
    low = hn::Min(low, hn::LoadU(F(), values + i));
    high = hn::Max(high, hn::LoadU(F(), values + i));
  }
  bounds[0] = hn::GetLane(hn::MinOfLanes(F(), low));
  bounds[1] = hn::GetLane(hn::MaxOfLanes(F(), high));
}

// Bit i: whether answer i has this bit.
HWY_INLINE uint64_t bits_of_run(const Visibility* answers, uint8_t bit) {
  const hn::FixedTag<uint8_t, kRun> bytes;
  uint8_t bits[8] = {};
  const auto wanted = hn::Set(bytes, bit);
  hn::StoreMaskBits(bytes, hn::Eq(hn::And(hn::LoadU(bytes, reinterpret_cast<const uint8_t*>(answers)), wanted), wanted), bits);
  return static_cast<uint64_t>(bits[0] | bits[1] << 8);
}

// The four corner lines of each run's rectangle on the light.
struct Corners {
  HWY_ALIGN uint32_t stuv[4 * kRuns], route[4 * kRuns];  // route: pair and whether swapped; kNoRoute: not to be used
  HWY_ALIGN uint32_t pierces[4 * kRuns];
};
constexpr uint32_t kNoRoute = 0xFF;

template <class Grid>
HWY_INLINE void locate_corners(const Grid& grid, const BeamFrame& frame, const float* u, const float* v, size_t count, Corners& corners) {
  for (size_t at = 0; at < count; at += kWidth) {
    const Floats cu = hn::Load(F(), u + at), cv = hn::Load(F(), v + at);
    Lanes lanes;
    for (int a = 0; a < 3; ++a) {
      lanes.origin[a] = all(frame.origin[a]);
      lanes.direction[a] = hn::Add(hn::Add(all(frame.corner[a]), hn::Mul(cu, all(frame.edge_u[a]))), hn::Mul(cv, all(frame.edge_v[a])));
    }
    const Lines lines = grid.corner_lines(frame, lanes, cu, cv);
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

// In the object's own frame.
struct OwnGrid {
  const ObjectData& data;

  HWY_INLINE Lines corner_lines(const BeamFrame&, const Lanes& lanes, Floats, Floats) const { return locate_lines(data.frame, lanes); }
  void look_up(const SegmentArrays& segments, Visibility* answers) const { data.many.arrays(data, segments, answers); }
};

// In a scene's frame.
struct PlacedGrid {
  const ObjectData& data;
  const ToGrid& grid;

  HWY_INLINE Lines corner_lines(const BeamFrame& frame, const Lanes& lanes, Floats u, Floats v) const {
    InGrid in = in_grid(grid, lanes);
    Floats size[3];
    for (int a = 0; a < 3; ++a)
      size[a] = hn::Add(hn::Add(hn::Abs(all(frame.corner[a])), hn::Abs(hn::Mul(u, all(frame.edge_u[a])))), hn::Abs(hn::Mul(v, all(frame.edge_v[a]))));
    in.moving = weighted(grid, size);
    return locate_placed(in);
  }
  void look_up(const SegmentArrays& segments, Visibility* answers) const { data.many.placed(data, grid, segments, answers); }
};

// Those runs whose bit in `live` is set; answers of the others stay as they are. blocked, open: the chunk's.
template <class Grid, class Directions>
HWY_INLINE void classify_chunk_of(const Grid& grid, const BeamFrame& frame, const BundleChunk& chunk, uint32_t live, const Directions& directions,
                                  uint64_t* blocked, uint64_t* open) {
  const size_t runs = chunk.runs();
  size_t undecided[kRuns], count = 0;
  if (runs == 0) return;
  if (frame.usable) {
    HWY_ALIGN float u[4 * kRuns], v[4 * kRuns];
    for (size_t r = 0; r < runs; ++r) {
      float u_bounds[2], v_bounds[2];
      bounds_of(chunk.u + r * kRun, kRun, u_bounds);
      bounds_of(chunk.v + r * kRun, kRun, v_bounds);
      for (size_t c = 0; c < 4; ++c) u[4 * r + c] = u_bounds[c & 1], v[4 * r + c] = v_bounds[c >> 1];
    }
    for (size_t i = 4 * runs; i % kWidth != 0; ++i) u[i] = u[0], v[i] = v[0];
    Corners corners;
    locate_corners(grid, frame, u, v, (4 * runs + kWidth - 1) / kWidth * kWidth, corners);
    const Visibility whole = beam_class(grid.data, corners, 0, 4 * runs);
    if (whole == Visibility::clear) return;
    for (size_t r = 0; r < runs; ++r) {
      if (!(live >> r & 1)) continue;
      const Visibility found = whole == Visibility::blocked ? whole : beam_class(grid.data, corners, 4 * r, 4);
      if (found == Visibility::blocked) blocked[r * kRun / 64] |= bits_from(r * kRun, chunk.in_run(r));
      if (found == Visibility::unclassified) undecided[count++] = r;
    }
  } else {
    for (size_t r = 0; r < runs; ++r)
      if (live >> r & 1) undecided[count++] = r;
  }
  if (count == 0) return;
  RunsAsArrays lone(frame.origin);
  for (size_t first = 0; first < count; first += RunsAsArrays::kMost) {
    const size_t some = std::min(RunsAsArrays::kMost, count - first);
    for (size_t k = 0; k < some; ++k)
      directions(undecided[first + k] * kRun, {lone.direction[0] + k * kRun, lone.direction[1] + k * kRun, lone.direction[2] + k * kRun});
    Visibility answers[kChunk];
    grid.look_up(lone.view(some), answers);
    for (size_t k = 0; k < some; ++k) {
      const size_t run = undecided[first + k], at = run * kRun;
      const uint64_t real = (uint64_t{1} << chunk.in_run(run)) - 1;
      blocked[at / 64] |= (bits_of_run(answers + k * kRun, 1) & real) << (at % 64);
      open[at / 64] |= (bits_of_run(answers + k * kRun, 2) & real) << (at % 64);
    }
  }
}

inline constexpr uint32_t kAllRuns = (uint32_t{1} << kRuns) - 1;

template <class Bundle>
void ClassifyBundleOf(const ObjectData& data, const Bundle& bundle, uint64_t* blocked, uint64_t* open) {
  clear_bits(bundle.size(), blocked, open);
  BeamFrame frame = beam_frame(bundle);
  frame.usable = frame.usable && near_enough(data.frame, frame);
  BundleChunk chunk;
  for (chunk.first = 0; chunk.first < bundle.size(); chunk.first += kBundleChunk) {
    chunk.count = std::min(kBundleChunk, bundle.size() - chunk.first);
    place(bundle, frame, chunk);
    float u[2], v[2];
    bounds_of(chunk.u, chunk.runs() * kRun, u);
    bounds_of(chunk.v, chunk.runs() * kRun, v);
    if (frame.usable && misses(data.frame, frame, u, v)) continue;
    classify_chunk_of(OwnGrid{data}, frame, chunk, kAllRuns, [&](size_t at, float* const(&into)[3]) HWY_ATTR {
      directions_of(bundle, frame, chunk, at, into);
    }, blocked + chunk.first / 64, open + chunk.first / 64);
  }
}

// One instance of a scene that is near enough. directions: of all the chunk's segments, whole runs of them.
void ClassifyBundleIn(const ObjectData& data, const ToGrid& grid, const BeamFrame& frame, const BundleChunk& chunk, uint32_t live,
                      const float* const (&directions)[3], uint64_t* blocked, uint64_t* open) {
  classify_chunk_of(PlacedGrid{data, grid}, frame, chunk, live, [&](size_t at, float* const(&into)[3]) HWY_ATTR {
    for (size_t a = 0; a < 3; ++a) std::copy_n(directions[a] + at, kRun, into[a]);
  }, blocked, open);
}
}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
