// Bundles: segments from one point to one light, as beams where their cells agree.
#if defined(VCD_RUNTIME_BEAM_BUNDLES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_BEAM_BUNDLES_INL_H
#undef VCD_RUNTIME_BEAM_BUNDLES_INL_H
#else
#define VCD_RUNTIME_BEAM_BUNDLES_INL_H
#endif

#include <cmath>

#include <vcd/runtime/bundle.h>

#include "beam/beam.h"
#include "lookup/grids-inl.h"
#include "lookup/kernels.h"
#include "lookup/range_class.h"
#include "lookup/segment_columns.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

static_assert(kWidth >= 4 && kRun % kWidth == 0 && kTogether % kRun == 0);  // four corner lines

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
HWY_NOINLINE void MeasureChunk(BundleChunk& chunk) noexcept {
  chunk.u_extent = extent_of(chunk.u, chunk.runs() * kRun);
  chunk.v_extent = extent_of(chunk.v, chunk.runs() * kRun);
}

// Bit i: whether answer i is the wanted one.
HWY_INLINE uint64_t bits_of_run(const Visibility* answers, Visibility answer) {
  const hn::FixedTag<uint8_t, kRun> bytes;
  uint8_t bits[8] = {};
  const auto wanted = hn::Set(bytes, static_cast<uint8_t>(answer));
  hn::StoreMaskBits(bytes, hn::Eq(hn::LoadU(bytes, reinterpret_cast<const uint8_t*>(answers)), wanted), bits);
  return static_cast<uint64_t>(bits[0] | bits[1] << 8);
}

// What all lines through the chunk's part of the beam's parallelogram have in common.
template <class Grid>
HWY_INLINE Visibility beam_class(const Grid& grid, const TreeView& tree, const BeamFrame& frame,
                                 const BundleChunk& chunk) {
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
  const Lines lines = grid.corner_lines(frame, chunk, lanes);
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
  const uint32_t up = 8 - tree.shape.levels;
  for (size_t c = 0; c < 4; ++c)
    for (int d = 0; d < 4; ++d) {
      const uint32_t x = (stuv[c] >> (24 - 8 * d) & 255) >> up;
      range.low[d] = std::min(range.low[d], x), range.high[d] = std::max(range.high[d], x);
    }
  const Visibility found = range_class(tree, range);
  const bool pierce = hn::AllTrue(F(), hn::Le(lines.exit, all(1.0f)));
  return found == Visibility::blocked && !pierce ? Visibility::unclassified : found;
}

// What a bundle needs of its grid, beside what <grids-inl.h> has: the lines of its corners, and whole runs looked up.
struct OwnBundleGrid {
  const GridFrame& frame;

  HWY_INLINE Lines corner_lines(const BeamFrame&, const BundleChunk&, const Lanes& lanes) const {
    return locate_lines(frame, lanes);
  }
  void look_up(const LookUp& at, const SegmentArrays& segments, Visibility* answers) const {
    at.kernels->arrays(frame, *at.tree, segments, answers);
  }
};

struct PlacedBundleGrid {
  const ToGrid& grid;

  HWY_INLINE Lines corner_lines(const BeamFrame& frame, const BundleChunk& chunk, const Lanes& lanes) const {
    InGrid in = in_grid(grid, lanes);
    Floats size[3];
    for (int a = 0; a < 3; ++a) size[a] = all(frame.rounding * chunk.size[a]);
    in.moving = weighted(grid, size);
    return locate_placed(in);
  }
  void look_up(const LookUp& at, const SegmentArrays& segments, Visibility* answers) const {
    at.kernels->placed(grid, *at.tree, segments, answers);
  }
};

// Runs whose bit in `live` is set; answers of the others stay as they are. as_beam: the object is near enough.
// directions(at, into): those of the run that begins with sample `at`.
template <class Grid, class Directions>
HWY_INLINE void classify_chunk(const Grid& grid, const LookUp& look_up, const BeamFrame& frame,
                               const BundleChunk& chunk, uint32_t live, bool as_beam, const Directions& directions,
                               SampleAnswers& answers) {
  if (as_beam && is_narrow(frame, chunk)) {
    const Visibility found = beam_class(grid, *look_up.tree, frame, chunk);
    if (found == Visibility::clear) return;
    if (found == Visibility::blocked) {
      for (size_t r = 0; r < chunk.runs(); ++r)
        if (live >> r & 1) answers.blocked.add_run(r, chunk.real(r));
      return;
    }
  }
  size_t undecided[kRuns], count = 0;
  for (size_t r = 0; r < chunk.runs(); ++r)
    if (live >> r & 1) undecided[count++] = r;
  constexpr size_t kMost = kTogether / kRun;
  SegmentColumns<kTogether> columns;
  columns.set_origin(frame.origin, kTogether);
  for (size_t first = 0; first < count; first += kMost) {
    const size_t some = std::min(kMost, count - first);
    for (size_t k = 0; k < some; ++k)
      directions(undecided[first + k] * kRun,
                 {columns.direction[0] + k * kRun, columns.direction[1] + k * kRun, columns.direction[2] + k * kRun});
    Visibility found[kTogether];
    grid.look_up(look_up, columns.view(0, some * kRun), found);
    for (size_t k = 0; k < some; ++k) {
      const size_t r = undecided[first + k];
      answers.blocked.add_run(r, bits_of_run(found + k * kRun, Visibility::blocked) & chunk.real(r));
      answers.unclassified.add_run(r, bits_of_run(found + k * kRun, Visibility::unclassified) & chunk.real(r));
    }
  }
}

template <class Bundle>
void ClassifyBundle(const GridFrame& grid, const LookUp& look_up, const Bundle& bundle, uint64_t* blocked,
                    uint64_t* unclassified) noexcept {
  constexpr uint32_t kAllRuns = (uint32_t{1} << kRuns) - 1;
  const BeamFrame frame = beam_frame(bundle);
  BundleChunk chunk;
  for (chunk.first = 0; chunk.first < bundle.size(); chunk.first += kChunk) {
    chunk.count = std::min(kChunk, bundle.size() - chunk.first);
    place(bundle, frame, chunk);
    MeasureChunk(chunk);
    set_size(frame, chunk);
    SampleAnswers answers;
    const bool as_beam = frame.usable && near_enough(grid, frame, chunk);
    if (!as_beam || !misses(grid, frame, chunk))
      classify_chunk(
          OwnBundleGrid{grid}, look_up, frame, chunk, kAllRuns, as_beam,
          [&](size_t at, float* const(&into)[3]) HWY_ATTR { directions_of(bundle, frame, chunk, at, into); }, answers);
    answers.blocked.store(chunk.count, blocked + chunk.first / 64);
    answers.unclassified.store(chunk.count, unclassified + chunk.first / 64);
  }
}

// One instance of a scene that is near enough.
void ClassifyPlacedBundle(const LookUp& look_up, const PlacedBundle& bundle, SampleAnswers& answers) noexcept {
  classify_chunk(
      PlacedBundleGrid{bundle.grid}, look_up, bundle.frame, bundle.chunk, bundle.live, true,
      [&](size_t at, float* const(&into)[3]) HWY_ATTR {
        for (size_t a = 0; a < 3; ++a) std::copy_n(bundle.directions[a] + at, kRun, into[a]);
      },
      answers);
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
