// <grids.h> for lanes: segments in the object's own frame, or of the world in the grid of an instance.
#if defined(VCD_RUNTIME_LOOKUP_GRIDS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_LOOKUP_GRIDS_INL_H
#undef VCD_RUNTIME_LOOKUP_GRIDS_INL_H
#else
#define VCD_RUNTIME_LOOKUP_GRIDS_INL_H
#endif

#include "lookup/lanes-inl.h"
#include "lookup/to_grid.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

struct InGrid {
  Lanes lanes;
  Floats fixed, moving;  // what rounding grows with: fixed + |t| · moving, grid units
};

HWY_INLINE Floats weighted(const ToGrid& grid, const Floats (&x)[3]) {
  Floats sum = hn::Mul(all(grid.column[0][3]), hn::Abs(x[0]));
  for (size_t a = 1; a < 3; ++a) sum = hn::Add(sum, hn::Mul(all(grid.column[a][3]), hn::Abs(x[a])));
  return sum;
}
HWY_INLINE Floats norm(const Floats (&x)[3]) { return hn::Add(hn::Add(hn::Abs(x[0]), hn::Abs(x[1])), hn::Abs(x[2])); }

// One instance for all lanes.
HWY_INLINE InGrid in_grid(const ToGrid& grid, const Lanes& world) {
  Floats o[3];
  for (size_t a = 0; a < 3; ++a) o[a] = hn::Sub(world.origin[a], all(grid.centre[a]));
  InGrid in;
  in.lanes.t_min = world.t_min, in.lanes.t_max = world.t_max;
  for (size_t i = 0; i < 3; ++i) {
    const Floats c0 = all(grid.column[0][i]), c1 = all(grid.column[1][i]), c2 = all(grid.column[2][i]);
    in.lanes.origin[i] =
        hn::Add(hn::Add(hn::Mul(c0, o[0]), hn::Mul(c1, o[1])), hn::Add(hn::Mul(c2, o[2]), all(grid.offset[i])));
    in.lanes.direction[i] = hn::Add(hn::Add(hn::Mul(c0, world.direction[0]), hn::Mul(c1, world.direction[1])),
                                    hn::Mul(c2, world.direction[2]));
  }
  in.fixed = hn::Add(weighted(grid, o), norm(in.lanes.origin));
  in.moving = weighted(grid, world.direction);
  return in;
}

// A segment by itself, by placed(): its origin and its direction, and in their fourth lanes what the fixed and the
// moving part of rounding grow with.
struct PlacedParts {
  hn::Vec<hn::FixedTag<float, 4>> origin, direction;
};
HWY_INLINE PlacedParts placed_parts(const ToGrid& grid, const Segment& world) {
  const hn::FixedTag<float, 4> four;
  const hn::RebindToUnsigned<decltype(four)> words;
  HWY_ALIGN constexpr uint32_t kBut[4] = {~0u, ~0u, ~0u, 0x7FFFFFFFu};  // the fourth without its sign
  const auto but = hn::BitCast(four, hn::Load(words, kBut));
  const auto o = hn::Sub(hn::LoadU(four, world.origin), hn::Load(four, grid.centre)),
             d = hn::LoadU(four, world.direction);
  const auto c0 = hn::Load(four, grid.column[0]), c1 = hn::Load(four, grid.column[1]),
             c2 = hn::Load(four, grid.column[2]);
  const auto times = [&](auto column, auto x) HWY_ATTR { return hn::Mul(column, hn::And(x, but)); };
  return {
      hn::Add(hn::Add(times(c0, hn::Broadcast<0>(o)), times(c1, hn::Broadcast<1>(o))),
              hn::Add(times(c2, hn::Broadcast<2>(o)), hn::Load(four, grid.offset))),
      hn::Add(hn::Add(times(c0, hn::Broadcast<0>(d)), times(c1, hn::Broadcast<1>(d))), times(c2, hn::Broadcast<2>(d)))};
}

// Valid are those that the guard band covers.
HWY_INLINE Lines locate_placed(const InGrid& in) {
  Lines lines = locate_lines(kGridItself, in.lanes);
  const Floats reach = hn::Add(in.fixed, hn::Mul(hn::Max(hn::Abs(lines.entry), hn::Abs(lines.exit)), in.moving));
  lines.valid = hn::And(lines.valid, hn::Le(reach, all(kFarthestReach)));
  return lines;
}

struct OwnLanes {
  const GridFrame& frame;

  HWY_INLINE LocatedLanes locate(const Lanes& lanes) const { return {lanes, locate_lines(frame, lanes)}; }
};

struct PlacedLanes {
  const ToGrid& grid;

  HWY_INLINE LocatedLanes locate(const Lanes& world) const {
    const InGrid in = in_grid(grid, world);
    return {in.lanes, locate_placed(in)};
  }
};

// Segments of the world in the object's frame. count: a multiple of kRun; `into` likewise.
HWY_NOINLINE void ToObject(const ToGrid& grid, const ToFrame& frame, const SegmentArrays& world,
                           float* const (&origin)[3], float* const (&direction)[3]) noexcept {
  for (size_t i = 0; i < world.count; i += kWidth) {
    const InGrid in = in_grid(grid, load(world, i));
    for (size_t a = 0; a < 3; ++a) {
      hn::StoreU(hn::Add(hn::Mul(in.lanes.origin[a], all(frame.unit[a])), all(frame.min[a])), F(), origin[a] + i);
      hn::StoreU(hn::Mul(in.lanes.direction[a], all(frame.unit[a])), F(), direction[a] + i);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
