// Segments of a scene in the grids of its instances, one a lane. See spec/design.md, "Scenes".
#if defined(VCD_RUNTIME_PLACED_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_PLACED_INL_H
#undef VCD_RUNTIME_PLACED_INL_H
#else
#define VCD_RUNTIME_PLACED_INL_H
#endif

#include "lanes-inl.h"
#include "scene_data.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

// One instance for all lanes.
struct OneInstance {
  const ToGrid& grid;
  Floats operator()(size_t k) const { return all((&grid.centre[0])[k]); }
};

struct InGrid {
  Lanes lanes;
  Floats fixed, moving;  // what rounding grows with: fixed + |t| · moving, grid units
};

template <class Of>
HWY_INLINE Floats weighted(const Of& of, const Floats (&x)[3]) {
  Floats sum = hn::Mul(of(15), hn::Abs(x[0]));
  for (size_t a = 1; a < 3; ++a) sum = hn::Add(sum, hn::Mul(of(15 + a), hn::Abs(x[a])));
  return sum;
}
HWY_INLINE Floats norm(const Floats (&x)[3]) { return hn::Add(hn::Add(hn::Abs(x[0]), hn::Abs(x[1])), hn::Abs(x[2])); }

// of(k): float k of a lane's ToGrid.
template <class Of>
HWY_INLINE InGrid in_grid(const Of& of, const Lanes& world) {
  Floats o[3];
  for (size_t a = 0; a < 3; ++a) o[a] = hn::Sub(world.origin[a], of(a));
  InGrid in;
  in.lanes.t_min = world.t_min, in.lanes.t_max = world.t_max;
  for (size_t i = 0; i < 3; ++i) {
    const Floats r0 = of(3 + 3 * i), r1 = of(4 + 3 * i), r2 = of(5 + 3 * i);
    in.lanes.origin[i] = hn::Add(hn::Add(hn::Mul(r0, o[0]), hn::Mul(r1, o[1])), hn::Add(hn::Mul(r2, o[2]), of(12 + i)));
    in.lanes.direction[i] = hn::Add(hn::Add(hn::Mul(r0, world.direction[0]), hn::Mul(r1, world.direction[1])), hn::Mul(r2, world.direction[2]));
  }
  in.fixed = hn::Add(weighted(of, o), norm(in.lanes.origin));
  in.moving = weighted(of, world.direction);
  return in;
}

// Valid are those that the guard band covers.
HWY_INLINE Lines locate_placed(const InGrid& in) {
  constexpr GridFrame kGridItself = {{0, 0, 0, 0}, {1, 1, 1, 0}};
  Lines lines = locate_lines(kGridItself, in.lanes);
  const Floats reach = hn::Add(in.fixed, hn::Mul(hn::Max(hn::Abs(lines.entry), hn::Abs(lines.exit)), in.moving));
  lines.valid = hn::And(lines.valid, hn::Le(reach, all(kFarthestReach)));
  return lines;
}

// count: a multiple of kRun.
template <uint32_t kDepth>
void ClassifyPlacedOf(const ObjectData& data, const ToGrid& grid, const SegmentArrays& segments, Visibility* answers) {
  for (size_t done = 0; done < segments.count; done += kChunk) {
    const size_t groups = std::min(kChunk, segments.count - done) / kWidth;
    classify_chunk<kDepth>(data.tree, groups, [&](size_t g) HWY_ATTR {
      const InGrid in = in_grid(OneInstance{grid}, load(segments, done + g * kWidth));
      return Located{in.lanes, locate_placed(in)};
    }, answers + done);
  }
}

// Segments of the world in the object's frame. count: a multiple of kRun; `into` likewise.
HWY_NOINLINE void ToObject(const ToGrid& grid, const ToFrame& frame, const SegmentArrays& world, float* const (&origin)[3], float* const (&direction)[3]) {
  for (size_t i = 0; i < world.count; i += kWidth) {
    const InGrid in = in_grid(OneInstance{grid}, load(world, i));
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
