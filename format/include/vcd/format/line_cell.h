// Line → cell: the one place that decides, to the last rounding, which cell of the 4-D line space a segment's line
// belongs to. The runtime looks cells up with it and the baker proves or samples the very lines it maps there.
// Normative text: spec/vcd-format.md, "Line to cell". Source of the parametrisation: Billen and Dutré 2016, section 3.
//
// Include only in translation units compiled without -ffast-math and with -ffp-contract=off: every operation below is
// one IEEE 754 binary32 operation, rounded to nearest even. No fused multiply-add is used, so that baseline x86-64,
// AVX2, AVX-512 and NEON builds all give the same bits.
#pragma once

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
struct alignas(16) GridFrame {
  float min[4];    // the fourth is 0
  float scale[4];  // 256 / (max - min); the fourth is 0
};
inline GridFrame make_grid_frame(const float min[3], const float max[3]) {
  GridFrame frame{};
  for (int a = 0; a < 3; ++a) {
    frame.min[a] = min[a];
    frame.scale[a] = kGrid / (max[a] - min[a]);
  }
  return frame;
}
inline float to_grid(const GridFrame& frame, int axis, float x) { return (x - frame.min[axis]) * frame.scale[axis]; }

// Limits of a box's extents, so that grid units and their inverse are normal numbers with room to spare. NaN: false.
inline bool usable_extent(float extent) { return extent >= 0x1p-100f && extent <= 0x1p100f; }

// Limits of a line, in the L1 norm of grid units: beyond them rounding could leave the padding of the box.
inline constexpr float kFarthestOrigin = 0x1p17f;  // 512 boxes
inline constexpr float kShortestDirection = 0x1p-40f;
inline constexpr float kLongestDirection = 0x1p100f;
inline constexpr float kSmallestComponent = 0x1p-100f;  // smaller direction components, zero too, count as this

struct LineCell {
  bool valid;     // false: an input is NaN, infinite or beyond the limits; nothing below may be used
  bool hits;      // the line passes through the inside of the box (no hit of the mesh)
  uint32_t pair;  // 0 … 14, meaningful when the line hits
  uint32_t s, t;  // on face kFacePair[pair].low, 0 … 255, in grid units rounded down
  uint32_t u, v;  // on face kFacePair[pair].high
  bool swapped;   // the line enters by face kFacePair[pair].high
  float t_entry;  // along the segment's own parameter
  float t_exit;
};

namespace detail {

// Three axes at a time, in the vector types that GCC and Clang have on every processor. The fourth lane is ballast.
typedef float Float4 __attribute__((vector_size(16)));
typedef int32_t Int4 __attribute__((vector_size(16)));

inline Float4 load(const float* from) {
  Float4 v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
inline Float4 smaller(Float4 a, Float4 b) { return a < b ? a : b; }
inline Float4 larger(Float4 a, Float4 b) { return a > b ? a : b; }
inline Float4 all(float x) { return Float4{x, x, x, x}; }

// The sign bits of lanes 0, 1, 2 (of a comparison: its truth) as bits 0, 1, 2.
inline uint32_t sign_bits(Int4 v) {
#ifdef __SSE2__
  return static_cast<uint32_t>(__builtin_ia32_movmskps(reinterpret_cast<Float4>(v))) & 7u;
#else
  return (static_cast<uint32_t>(v[0]) >> 31) | (static_cast<uint32_t>(v[1]) >> 31) << 1 |
         (static_cast<uint32_t>(v[2]) >> 31) << 2;
#endif
}

// Coordinates on faces → bytes, rounded down and clamped to the face: entry in bytes 0, 1, 2, exit in 4, 5, 6.
// Where a coordinate is not within 2^31 of the face (only for lines that miss the box), the byte is anything.
inline uint64_t grid_bytes(Float4 entry, Float4 exit) {
#ifdef __SSE2__
  typedef short Short8 __attribute__((vector_size(16)));
  typedef long long Long2 __attribute__((vector_size(16)));
  // Truncation, then two packs that saturate: to 16 bits with sign, to 8 bits without.
  const Int4 a = __builtin_ia32_cvttps2dq(entry), b = __builtin_ia32_cvttps2dq(exit);
  const Short8 words = __builtin_ia32_packssdw128(a, b);
  return static_cast<uint64_t>(reinterpret_cast<Long2>(__builtin_ia32_packuswb128(words, words))[0]);
#else
  const auto byte = [](float x) { return static_cast<uint64_t>(x > 0.0f ? (x < 255.0f ? x : 255.0f) : 0.0f); };
  uint64_t bytes = 0;
  for (int axis = 0; axis < 3; ++axis) bytes |= byte(entry[axis]) << (8 * axis) | byte(exit[axis]) << (32 + 8 * axis);
  return bytes;
#endif
}

// What the axes of entry and exit and the signs of the direction say: the face pair, and where in grid_bytes() its
// s, t, u, v stand.
struct Route {
  uint8_t pair;
  uint8_t shift[4];
  uint8_t swapped;
  uint8_t unused[2];
};
struct RouteTable {
  Route route[512];  // [axes of entry | axes of exit << 3 | negative directions << 6], the lowest of several axes wins
};
constexpr uint32_t lowest_axis(uint32_t bits) { return bits & 1 ? 0 : bits & 2 ? 1 : 2; }
constexpr RouteTable make_route_table() {
  RouteTable table{};
  for (uint32_t key = 0; key < 512; ++key) {
    const uint32_t entry = lowest_axis(key), exit = lowest_axis(key >> 3), negative = key >> 6;
    const uint32_t entry_face = 2 * entry + (negative >> entry & 1);
    const uint32_t exit_face = 2 * exit + ((negative >> exit & 1) ^ 1);
    const bool swapped = entry_face > exit_face;
    const uint32_t low = swapped ? exit_face : entry_face, high = swapped ? entry_face : exit_face;
    const uint32_t low_base = swapped ? 32 : 0, high_base = swapped ? 0 : 32;
    Route& route = table.route[key];
    route.swapped = swapped;
    for (uint32_t p = 0; p < kFacePairs; ++p)
      if (kFacePair[p].low == low && kFacePair[p].high == high) route.pair = static_cast<uint8_t>(p);
    route.shift[0] = static_cast<uint8_t>(low_base + 8 * face_axes(low).first);
    route.shift[1] = static_cast<uint8_t>(low_base + 8 * face_axes(low).second);
    route.shift[2] = static_cast<uint8_t>(high_base + 8 * face_axes(high).first);
    route.shift[3] = static_cast<uint8_t>(high_base + 8 * face_axes(high).second);
  }
  return table;
}
inline constexpr RouteTable kRoutes = make_route_table();

}  // namespace detail

// The cell of level 8, the deepest, of the line through a segment; a tree of less depth takes the upper bits.
// Branch-free; safe for any bit pattern of the inputs.
[[gnu::always_inline]] inline LineCell locate(const GridFrame& frame, const Segment& segment) {
  using namespace detail;
  const Int4 three_lanes = {-1, -1, -1, 0}, sign_mask = Int4{} + INT32_MIN;
  const auto masked = [](Float4 v, Int4 mask) { return reinterpret_cast<Float4>(reinterpret_cast<Int4>(v) & mask); };
  const Float4 scale = load(frame.scale);
  const Float4 p = (masked(load(segment.origin), three_lanes) - load(frame.min)) * scale;
  Float4 q = masked(load(segment.direction), three_lanes) * scale;

  // L1 norms of both: lane 0 is the origin's distance, lane 1 the direction's length.
  const Float4 absolute_p = masked(p, ~sign_mask), absolute_q = masked(q, ~sign_mask);
  const Float4 x_and_y = __builtin_shufflevector(absolute_p, absolute_q, 0, 4, 1, 5);
  const Float4 z = __builtin_shufflevector(absolute_p, absolute_q, 2, 6, 2, 6);
  const Float4 norms = (x_and_y + __builtin_shufflevector(x_and_y, x_and_y, 2, 3, 2, 3)) + z;
  const Float4 least = {0.0f, kShortestDirection, 0.0f, 0.0f}, most = {kFarthestOrigin, kLongestDirection, 0.0f, 0.0f};

  q = reinterpret_cast<Float4>(reinterpret_cast<Int4>(larger(absolute_q, all(kSmallestComponent))) |
                               (reinterpret_cast<Int4>(q) & sign_mask));
  const Float4 reciprocal = all(1.0f) / q;
  const Float4 at_low = (Float4{} - p) * reciprocal;
  const Float4 at_high = (all(kGrid) - p) * reciprocal;
  const Float4 near = smaller(at_low, at_high);
  const Float4 far = larger(at_low, at_high);
  const Float4 entry = larger(
      near, larger(__builtin_shufflevector(near, near, 1, 2, 0, 3), __builtin_shufflevector(near, near, 2, 0, 1, 3)));
  const Float4 exit = smaller(
      far, smaller(__builtin_shufflevector(far, far, 1, 2, 0, 3), __builtin_shufflevector(far, far, 2, 0, 1, 3)));

  LineCell cell;
  cell.valid = (sign_bits((norms >= least) & (norms <= most)) & 3u) == 3u;
  cell.t_entry = entry[0];
  cell.t_exit = exit[0];
  cell.hits = cell.t_entry < cell.t_exit;
  const uint32_t key =
      sign_bits(near == entry) | sign_bits(far == exit) << 3 | sign_bits(reinterpret_cast<Int4>(q)) << 6;
  const Route& route = kRoutes.route[key];
  const uint64_t bytes = grid_bytes(q * entry + p, q * exit + p);
  cell.pair = route.pair;
  cell.swapped = route.swapped;
  cell.s = static_cast<uint32_t>(bytes >> route.shift[0]) & 255u;
  cell.t = static_cast<uint32_t>(bytes >> route.shift[1]) & 255u;
  cell.u = static_cast<uint32_t>(bytes >> route.shift[2]) & 255u;
  cell.v = static_cast<uint32_t>(bytes >> route.shift[3]) & 255u;
  return cell;
}

}  // namespace vcd
