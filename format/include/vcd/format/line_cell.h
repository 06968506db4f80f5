// Line → cell: the one place that decides, to the last rounding, which cell of the 4-D line space a segment's line
// belongs to. The runtime looks cells up with it and the baker proves or samples the very lines it maps there.
// Normative text: spec/vcd-format.md, "Line to cell". Source of the parametrisation: Billen and Dutré 2016, section 3.
//
// Include only in translation units compiled without -ffast-math and with -ffp-contract=off: every operation below is
// one IEEE 754 binary32 operation, rounded to nearest even. No fused multiply-add is used, so that baseline x86-64,
// AVX2, AVX-512 and NEON builds all give the same bits.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include <vcd/format/segment.h>

#ifdef __FAST_MATH__
#error "line_cell.h needs IEEE arithmetic: compile without -ffast-math"
#endif

namespace vcd {

// Grid units: the padded box of an object is the cube [0, 256]^3. A cell of level L is 256 / 2^L units wide.
inline constexpr float kGrid = 256.0f;
inline constexpr uint32_t kFacePairs = 15;

// Faces: 2 * axis + side, side 0 where the coordinate is 0, side 1 where it is 256.
struct FacePair {
  uint8_t low;   // the face with the smaller number; owns (s, t)
  uint8_t high;  // the face with the larger number; owns (u, v)
};
inline constexpr FacePair kFacePair[kFacePairs] = {{0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}, {1, 2}, {1, 3}, {1, 4},
                                                   {1, 5}, {2, 3}, {2, 4}, {2, 5}, {3, 4}, {3, 5}, {4, 5}};

// The two axes of a face in increasing order: the first carries s (or u), the second t (or v).
struct FaceAxes {
  uint8_t normal, first, second;
};
inline constexpr FaceAxes face_axes(uint32_t face) {
  const uint8_t axis = static_cast<uint8_t>(face / 2);
  return {axis, static_cast<uint8_t>(axis == 0 ? 1 : 0), static_cast<uint8_t>(axis == 2 ? 1 : 2)};
}

// Object frame → grid frame: grid = (object - min) * scale.
struct GridFrame {
  float min[3];
  float scale[3];  // 256 / (max - min)
};
inline GridFrame make_grid_frame(const float min[3], const float max[3]) {
  GridFrame frame;
  for (int a = 0; a < 3; ++a) {
    frame.min[a] = min[a];
    frame.scale[a] = kGrid / (max[a] - min[a]);
  }
  return frame;
}
inline float to_grid(const GridFrame& frame, int axis, float x) { return (x - frame.min[axis]) * frame.scale[axis]; }

// Limits, in the L1 norm of grid units: beyond them rounding could leave the padding of the box.
inline constexpr float kFarthestOrigin = 0x1p18f;      // 1024 boxes
inline constexpr float kShortestDirection = 0x1p-40f;
inline constexpr float kLongestDirection = 0x1p100f;
inline constexpr float kSmallestComponent = 0x1p-100f;  // smaller direction components, zero too, count as this

struct LineCell {
  bool valid;      // false: an input is NaN, infinite or beyond the limits; nothing below may be used
  bool hits;       // the line passes through the inside of the box
  uint32_t pair;   // 0 … 14, meaningful when the line hits
  uint32_t s, t;   // on face kFacePair[pair].low, 0 … 255, in grid units rounded down
  uint32_t u, v;   // on face kFacePair[pair].high
  float t_entry;   // along the segment's own parameter
  float t_exit;
};

namespace detail {

// What entry axis, exit axis and the signs of the direction say: the face pair, and where in the six packed
// coordinate bytes (entry x, y, z, exit x, y, z) its s, t, u, v stand.
struct Route {
  uint8_t pair;
  uint8_t shift[4];
};
struct RouteTable {
  Route route[72];  // [(entry axis * 3 + exit axis) * 8 + sign bits]
};
constexpr RouteTable make_route_table() {
  RouteTable table{};
  for (uint32_t entry = 0; entry < 3; ++entry)
    for (uint32_t exit = 0; exit < 3; ++exit)
      for (uint32_t signs = 0; signs < 8; ++signs) {
        const uint32_t entry_face = 2 * entry + ((signs >> entry) & 1);
        const uint32_t exit_face = 2 * exit + (((signs >> exit) & 1) ^ 1);
        const bool swapped = entry_face > exit_face;
        const uint32_t low = swapped ? exit_face : entry_face;
        const uint32_t high = swapped ? entry_face : exit_face;
        Route& route = table.route[(entry * 3 + exit) * 8 + signs];
        for (uint32_t p = 0; p < kFacePairs; ++p)
          if (kFacePair[p].low == low && kFacePair[p].high == high) route.pair = static_cast<uint8_t>(p);
        const uint32_t low_base = swapped ? 24 : 0, high_base = swapped ? 0 : 24;
        route.shift[0] = static_cast<uint8_t>(low_base + 8 * face_axes(low).first);
        route.shift[1] = static_cast<uint8_t>(low_base + 8 * face_axes(low).second);
        route.shift[2] = static_cast<uint8_t>(high_base + 8 * face_axes(high).first);
        route.shift[3] = static_cast<uint8_t>(high_base + 8 * face_axes(high).second);
      }
  return table;
}
inline constexpr RouteTable kRoutes = make_route_table();

inline float smaller(float a, float b) { return a < b ? a : b; }
inline float larger(float a, float b) { return a > b ? a : b; }

// A coordinate on a face → its byte: rounded down, clamped to the face. NaN gives 0.
inline uint64_t grid_byte(float x) {
  return static_cast<uint64_t>(static_cast<int32_t>(smaller(larger(x, 0.0f), 255.0f)));
}

// Direction components of tiny or zero length become ±2^-100: no division by zero, no subnormals, and the line turns
// by less than 2^-41 grid units inside the box.
inline float usable_component(float q) {
  return std::copysign(larger(std::fabs(q), kSmallestComponent), q);
}

}  // namespace detail

// The cell of the line through a segment. Branch-free; safe for any bit pattern of the inputs.
inline LineCell locate(const GridFrame& frame, const Segment& segment) {
  using detail::larger;
  using detail::smaller;
  float p[3], q[3], near[3], far[3];
  uint32_t signs = 0;
  for (int a = 0; a < 3; ++a) {
    p[a] = (segment.origin[a] - frame.min[a]) * frame.scale[a];
    q[a] = segment.direction[a] * frame.scale[a];
  }
  const float distance = std::fabs(p[0]) + std::fabs(p[1]) + std::fabs(p[2]);
  const float length = std::fabs(q[0]) + std::fabs(q[1]) + std::fabs(q[2]);
  for (int a = 0; a < 3; ++a) {
    q[a] = detail::usable_component(q[a]);
    const float reciprocal = 1.0f / q[a];
    const float at_low = (0.0f - p[a]) * reciprocal;
    const float at_high = (kGrid - p[a]) * reciprocal;
    near[a] = smaller(at_low, at_high);
    far[a] = larger(at_low, at_high);
    signs |= (std::bit_cast<uint32_t>(q[a]) >> 31) << a;
  }

  // The lowest axis wins a tie.
  const float near01 = larger(near[0], near[1]);
  const float far01 = smaller(far[0], far[1]);
  const uint32_t entry01 = near[1] > near[0];
  const uint32_t exit01 = far[1] < far[0];
  const uint32_t entry_axis = near[2] > near01 ? 2u : entry01;
  const uint32_t exit_axis = far[2] < far01 ? 2u : exit01;

  LineCell cell;
  cell.t_entry = larger(near01, near[2]);
  cell.t_exit = smaller(far01, far[2]);
  cell.valid = (distance <= kFarthestOrigin) & (length >= kShortestDirection) & (length <= kLongestDirection);
  cell.hits = cell.t_entry < cell.t_exit;

  uint64_t bytes = 0;
  for (int a = 0; a < 3; ++a) {
    bytes |= detail::grid_byte(q[a] * cell.t_entry + p[a]) << (8 * a);
    bytes |= detail::grid_byte(q[a] * cell.t_exit + p[a]) << (24 + 8 * a);
  }
  const detail::Route& route = detail::kRoutes.route[(entry_axis * 3 + exit_axis) * 8 + signs];
  cell.pair = route.pair;
  cell.s = static_cast<uint32_t>(bytes >> route.shift[0]) & 255u;
  cell.t = static_cast<uint32_t>(bytes >> route.shift[1]) & 255u;
  cell.u = static_cast<uint32_t>(bytes >> route.shift[2]) & 255u;
  cell.v = static_cast<uint32_t>(bytes >> route.shift[3]) & 255u;
  return cell;
}

}  // namespace vcd
