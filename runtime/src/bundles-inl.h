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

static_assert(kWidth >= 4 && kRun % kWidth == 0 && kChunk % kRun == 0);  // four corner lines

// Directions of one run's segments.
HWY_INLINE void directions_of(const QuadBundle&, const BeamFrame& frame, const BundleChunk& chunk, size_t at,
                              float* const (&into)[3]) {
  for (size_t i = 0; i < kRun; i += kWidth) {
    const Floats u = hn::LoadU(F(), chunk.u + at + i), v = hn::LoadU(F(), chunk.v + at + i);
    for (int a = 0; a < 3; ++a)
      hn::StoreU(
          hn::Add(hn::Add(all(frame.corner[a]), hn::Mul(u, all(frame.edge_u[a]))), hn::Mul(v, all(frame.edge_v[a]))),
          F(), into[a] + i);
  }
}
HWY_INLINE void directions_of(const SphereBundle& bundle, const BeamFrame&, const BundleChunk& chunk, size_t at,
                              float* const (&into)[3]) {
  for (size_t k = 0; k < kRun; ++k) {
    const size_t i = chunk.first + std::min(at + k, chunk.count - 1);
    into[0][k] = bundle.x[i] - bundle.origin[0], into[1][k] = bundle.y[i] - bundle.origin[1],
    into[2][k] = bundle.z[i] - bundle.origin[2];
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
HWY_INLINE Extent extent_of(const float* values, size_t count) {
  Floats low = hn::LoadU(F(), values), high = low;
  Truth doubtful = hn::IsNaN(low);
  for (size_t i = kWidth; i < count; i += kWidth) {
    const Floats x = hn::LoadU(F(), values + i);
    low = hn::Min(low, x), high = hn::Max(high, x);
    doubtful = hn::Or(doubtful, hn::IsNaN(x));
  }
  if (!hn::AllFalse(F(), doubtful)) return Extent::nan();
  return {hn::GetLane(hn::MinOfLanes(F(), low)), hn::GetLane(hn::MaxOfLanes(F(), high))};
}
HWY_NOINLINE void MeasureChunk(BundleChunk& chunk) {
  chunk.u_extent = extent_of(chunk.u, chunk.runs() * kRun);
  chunk.v_extent = extent_of(chunk.v, chunk.runs() * kRun);
}

// Bit i: whether answer i has this bit.
HWY_INLINE uint64_t bits_of_run(const Visibility* answers, uint8_t bit) {
  const hn::FixedTag<uint8_t, kRun> bytes;
  uint8_t bits[8] = {};
  const auto wanted = hn::Set(bytes, bit);
  hn::StoreMaskBits(bytes, hn::Eq(hn::And(hn::LoadU(bytes, reinterpret_cast<const uint8_t*>(answers)), wanted), wanted),
                    bits);
  return static_cast<uint64_t>(bits[0] | bits[1] << 8);
}

// What all lines through the chunk's part of the beam's parallelogram have in common.
template <class Grid>
HWY_INLINE Visibility beam_class(const Grid& grid, const BeamFrame& frame, const BundleChunk& chunk) {
  HWY_ALIGN float u[kWidth], v[kWidth];
  for (size_t c = 0; c < kWidth; ++c) {
    u[c] = c & 1 ? chunk.u_extent.high : chunk.u_extent.low;
    v[c] = c >> 1 & 1 ? chunk.v_extent.high : chunk.v_extent.low;
  }
  const Floats cu = hn::Load(F(), u), cv = hn::Load(F(), v);
  Lanes lanes;
  for (int a = 0; a < 3; ++a) {
    lanes.origin[a] = all(frame.origin[a]);
    lanes.direction[a] =
        hn::Add(hn::Add(all(frame.corner[a]), hn::Mul(cu, all(frame.edge_u[a]))), hn::Mul(cv, all(frame.edge_v[a])));
  }
  const Lines lines = grid.corner_lines(frame, lanes, cu, cv);
  const Truth usable = hn::And(hn::And(lines.valid, hn::Lt(lines.entry, lines.exit)),
                               hn::And(hn::Gt(lines.entry, hn::Zero(F())), hn::Le(lines.exit, all(kFarthestExit))));
  // Which face pair, and which face first.
  const Words route =
      hn::Or(hn::ShiftLeft<1>(lines.pair), hn::IfThenElseZero(hn::RebindMask(U(), lines.swapped), all(1u)));
  const uint32_t first = hn::GetLane(route);
  if (!hn::AllTrue(F(), hn::And(usable, hn::RebindMask(F(), hn::Eq(route, all(first))))))
    return Visibility::unclassified;
  HWY_ALIGN uint32_t stuv[kWidth];
  hn::Store(lines.stuv, U(), stuv);
  CellRange range{first >> 1, {255, 255, 255, 255}, {}};
  const uint32_t up = 8 - grid.data.tree.shape.levels;
  for (size_t c = 0; c < 4; ++c)
    for (int d = 0; d < 4; ++d) {
      const uint32_t x = (stuv[c] >> (24 - 8 * d) & 255) >> up;
      range.low[d] = std::min(range.low[d], x), range.high[d] = std::max(range.high[d], x);
    }
  const Visibility found = range_class(grid.data.tree, range);
  const bool pierce = hn::AllTrue(F(), hn::Le(lines.exit, all(1.0f)));
  return found == Visibility::blocked && !pierce ? Visibility::unclassified : found;
}

// In the object's own frame.
struct OwnGrid {
  const ObjectData& data;

  HWY_INLINE Lines corner_lines(const BeamFrame&, const Lanes& lanes, Floats, Floats) const {
    return locate_lines(data.frame, lanes);
  }
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
      size[a] = hn::Add(hn::Add(hn::Abs(all(frame.corner[a])), hn::Abs(hn::Mul(u, all(frame.edge_u[a])))),
                        hn::Abs(hn::Mul(v, all(frame.edge_v[a]))));
    in.moving = weighted(grid, size);
    return locate_placed(in);
  }
  void look_up(const SegmentArrays& segments, Visibility* answers) const {
    data.many.placed(data, grid, segments, answers);
  }
};

// Those runs whose bit in `live` is set; answers of the others stay as they are. as_beam: the object is near enough.
// blocked, open: the chunk's.
template <class Grid, class Directions>
HWY_INLINE void classify_chunk_of(const Grid& grid, const BeamFrame& frame, const BundleChunk& chunk, uint32_t live,
                                  bool as_beam, const Directions& directions, uint64_t* blocked, uint64_t* open) {
  if (as_beam) {
    const Visibility found = beam_class(grid, frame, chunk);
    if (found == Visibility::clear) return;
    if (found == Visibility::blocked) {
      for (size_t r = 0; r < chunk.runs(); ++r)
        if (live >> r & 1) blocked[r * kRun / 64] |= bits_from(r * kRun, chunk.in_run(r));
      return;
    }
  }
  size_t undecided[kRuns], count = 0;
  for (size_t r = 0; r < chunk.runs(); ++r)
    if (live >> r & 1) undecided[count++] = r;
  RunsAsArrays lone(frame.origin);
  for (size_t first = 0; first < count; first += RunsAsArrays::kMost) {
    const size_t some = std::min(RunsAsArrays::kMost, count - first);
    for (size_t k = 0; k < some; ++k)
      directions(undecided[first + k] * kRun,
                 {lone.direction[0] + k * kRun, lone.direction[1] + k * kRun, lone.direction[2] + k * kRun});
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
  const BeamFrame frame = beam_frame(bundle);
  BundleChunk chunk;
  for (chunk.first = 0; chunk.first < bundle.size(); chunk.first += kBundleChunk) {
    chunk.count = std::min(kBundleChunk, bundle.size() - chunk.first);
    place(bundle, frame, chunk);
    MeasureChunk(chunk);
    const bool as_beam = frame.usable && near_enough(data.frame, frame, chunk);
    if (as_beam && misses(data.frame, frame, chunk)) continue;
    classify_chunk_of(
        OwnGrid{data}, frame, chunk, kAllRuns, as_beam,
        [&](size_t at, float* const(&into)[3]) HWY_ATTR { directions_of(bundle, frame, chunk, at, into); },
        blocked + chunk.first / 64, open + chunk.first / 64);
  }
}

// One instance of a scene that is near enough. directions: of all the chunk's segments, whole runs of them.
void ClassifyBundleIn(const ObjectData& data, const ToGrid& grid, const BeamFrame& frame, const BundleChunk& chunk,
                      uint32_t live, const float* const (&directions)[3], uint64_t* blocked, uint64_t* open) {
  classify_chunk_of(
      PlacedGrid{data, grid}, frame, chunk, live, true,
      [&](size_t at, float* const(&into)[3]) HWY_ATTR {
        for (size_t a = 0; a < 3; ++a) std::copy_n(directions[a] + at, kRun, into[a]);
      },
      blocked, open);
}
}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
