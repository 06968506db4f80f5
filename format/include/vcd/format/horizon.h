// The HORZ section: for each triangle of the source, above which directions nothing of the object stands. It proves
// segments clear that begin on the object itself. Normative text: spec/vcd-format.md, "HORZ section"; the proof and all
// constants: spec/proofs.md, "Horizons".
//
// What is promised speaks of places and directions alone: of segments that begin above a triangle of the object's
// hierarchy. That the number of the triangle is right is no part of it: a wrong number finds a triangle that the
// segment does not begin above.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>

#include <vcd/format/bytes.h>
#include <vcd/format/hierarchy.h>
#include <vcd/format/segment.h>

namespace vcd {

inline constexpr uint32_t kHorizonSectors = 16;  // of azimuth around a triangle's normal
inline constexpr uint32_t kHorizonSlopes = 16;   // that a sector can have: a code of 4 bits
inline constexpr uint32_t kHorizonTables = 4;    // of slopes, of which each triangle has one
inline constexpr uint32_t kHorizonNever = 15;    // the code of sectors in which nothing is known to be clear

struct HorizonHeader {
  uint32_t entries;       // as many as the source has triangles
  uint32_t reserved;      // zero
  uint64_t order_xxh3;    // of the order of the source's triangles
  float uniform, cosine;  // share of directions above the triangles that are answered, each by its weight
  float slope[kHorizonTables][kHorizonSlopes];  // by table and code, ascending; the last of each is +infinity
  uint32_t padding[10];                         // zero
};
static_assert(sizeof(HorizonHeader) == 320 && offsetof(HorizonHeader, order_xxh3) == 8 &&
              offsetof(HorizonHeader, uniform) == 16 && offsetof(HorizonHeader, slope) == 24 &&
              offsetof(HorizonHeader, padding) == 280);

// `place` names a triangle of the object's hierarchy and a side of it; 0: none, and all codes are kHorizonNever.
struct HorizonEntry {
  uint32_t place;
  uint8_t codes[kHorizonSectors / 2];  // sector s in bits 4 (s % 2) and above of byte s / 2
};
static_assert(sizeof(HorizonEntry) == 12);

// Of a place: the unit where the triangle's leaf begins, the table of its slopes, whether that is a large leaf, the
// triangle's number in it, and whether the side is the one that its corners in the order 0, 2, 1 turn
// counter-clockwise, instead of 0, 1, 2.
inline constexpr uint32_t kPlaceUnitMask = 0x00FFFFFF, kPlaceTableShift = 24, kPlaceLarge = 0x04000000,
                          kPlaceTriangleShift = 27, kPlaceTurned = 0x80000000;
constexpr uint32_t leaf_of(uint32_t place) {  // as the word of a child
  return kLeafChild | (place & kPlaceLarge ? kLargeChild : 0) | (place & kPlaceUnitMask);
}
constexpr uint32_t triangle_of(uint32_t place) { return place >> kPlaceTriangleShift & (kNodeWidth - 1); }
constexpr uint32_t table_of(uint32_t place) { return place >> kPlaceTableShift & (kHorizonTables - 1); }

// A section in memory, 64-byte aligned. No bytes: there is none.
struct HorizonView {
  const std::byte* data = nullptr;

  explicit operator bool() const { return data != nullptr; }
  const HorizonHeader& header() const { return *reinterpret_cast<const HorizonHeader*>(data); }
  const HorizonEntry* entries() const { return reinterpret_cast<const HorizonEntry*>(data + sizeof(HorizonHeader)); }
  size_t size() const { return sizeof(HorizonHeader) + size_t{header().entries} * sizeof(HorizonEntry); }
  Bytes all_bytes() const { return data ? Bytes(data, size()) : Bytes(); }
};

// What is wrong with a HORZ section, and at which of its bytes.
struct HorizonFault {
  enum class Kind : uint8_t {
    size,    // the header contradicts the section's size, or itself
    slopes,  // they do not ascend, or the last is not infinite
    place,   // an entry names no triangle of the hierarchy
  } kind;
  size_t offset;
};
// Looks at a section of 64-byte aligned bytes whose object has this hierarchy, which must be sound itself. With
// `bounds` at what keeps every query inside the two sections. With `canonical` at every byte. Throws std::bad_alloc.
std::optional<HorizonFault> check_horizon(Bytes section, const HierarchyView& hierarchy, CheckLevel level);

// The frame of one side of a triangle, in floats, to the bit the same wherever it is made: three axes that are nearly
// orthonormal, n nearly the normal. Everything that the section promises is about the three sums that these floats make
// of a vector. Corner 0 is the origin.
struct HorizonFrame {
  float corner[3];  // 0, in the object's frame
  float x[3], y[3], n[3];
  float size;             // the greatest component of the two edges from corner 0
  float u[3], v[3], top;  // the corners along x and y, and the greatest of them along n
};

namespace horizon {
// Of a segment that is answered: how far its begin may be from corner 0, and how far it may be moved by t_min, in each
// component and in `size`; how high above the triangle it must begin; how far inside, as an area.
inline constexpr float kNear = 2, kLowest = 0x1p-16f, kInside = 0x1p-14f;
// Of a direction: its greatest component.
inline constexpr float kShortest = 0x1p-40f, kLongest = 0x1p40f;
// Steeper directions count as straight up: they belong to no sector.
inline constexpr float kUpright = 0x1p-18f;  // (u² + v²) / w²
// The greatest slope but the last.
inline constexpr float kSteepest = 16;
// Twice the triangle's area, squared, in which n is computed without overflow or underflow.
inline constexpr float kLeastArea2 = 0x1p-100f, kMostArea2 = 0x1p100f;
// Of sectors: tan 22.5°.
inline constexpr float kTan = 0.41421356f;

inline float along(const float (&axis)[3], const float (&r)[3]) {
  return axis[0] * r[0] + axis[1] * r[1] + axis[2] * r[2];
}
inline float greatest(const float (&r)[3]) {
  return std::max(std::max(std::fabs(r[0]), std::fabs(r[1])), std::fabs(r[2]));
}
}  // namespace horizon

// False where floats cannot hold it, and nothing is promised. Corners in the order of the side.
inline bool make_horizon_frame(const float (&p)[3], const float (&q)[3], const float (&r)[3], HorizonFrame& f) {
  float a[3], b[3];
  for (int i = 0; i < 3; ++i) f.corner[i] = p[i], a[i] = q[i] - p[i], b[i] = r[i] - p[i];
  const float cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  const float area2 = horizon::along(cross, cross);
  if (!(area2 >= horizon::kLeastArea2 && area2 <= horizon::kMostArea2)) return false;
  const float length = std::sqrt(area2);
  for (int i = 0; i < 3; ++i) f.n[i] = cross[i] / length;
  // Duff et al., "Building an orthonormal basis, revisited", JCGT 2017.
  const float sign = std::copysign(1.0f, f.n[2]), c = -1.0f / (sign + f.n[2]), d = f.n[0] * f.n[1] * c;
  f.x[0] = 1.0f + sign * f.n[0] * f.n[0] * c, f.x[1] = sign * d, f.x[2] = -sign * f.n[0];
  f.y[0] = d, f.y[1] = sign + f.n[1] * f.n[1] * c, f.y[2] = -f.n[1];
  f.size = std::max(horizon::greatest(a), horizon::greatest(b));
  f.u[0] = f.v[0] = 0;
  f.u[1] = horizon::along(f.x, a), f.v[1] = horizon::along(f.y, a);
  f.u[2] = horizon::along(f.x, b), f.v[2] = horizon::along(f.y, b);
  f.top = std::max(std::max(horizon::along(f.n, a), horizon::along(f.n, b)), 0.0f);
  return true;
}

// Whether the point origin + t_min · direction is certainly above the triangle, and how it may be asked about.
inline bool begins_above(const HorizonFrame& f, const Segment& s) {
  float r[3], moved[3];
  for (int i = 0; i < 3; ++i) r[i] = s.origin[i] - f.corner[i], moved[i] = s.t_min * s.direction[i];
  const float near = horizon::kNear * f.size;
  if (!(std::fabs(r[0]) <= near && std::fabs(r[1]) <= near && std::fabs(r[2]) <= near)) return false;
  if (!(std::fabs(moved[0]) <= near && std::fabs(moved[1]) <= near && std::fabs(moved[2]) <= near)) return false;
  for (int i = 0; i < 3; ++i) r[i] += moved[i];
  const float u = horizon::along(f.x, r), v = horizon::along(f.y, r), w = horizon::along(f.n, r);
  if (!(w - f.top >= horizon::kLowest * f.size)) return false;
  const float inside = horizon::kInside * f.size * f.size;
  for (int i = 0; i < 3; ++i) {
    const int j = i == 2 ? 0 : i + 1;
    if (!((f.u[j] - f.u[i]) * (v - f.v[i]) - (f.v[j] - f.v[i]) * (u - f.u[i]) >= inside)) return false;
  }
  return true;
}

// The sector of an azimuth: eighths of a half-plane, counter-clockwise from u.
inline uint32_t horizon_sector(float u, float v) {
  const float a = std::fabs(u), b = std::fabs(v);
  uint32_t sector = std::min(a, b) > horizon::kTan * std::max(a, b);
  if (b > a) sector = 3 - sector;
  if (u < 0) sector = 7 - sector;
  return v < 0 ? 15 - sector : sector;
}

inline uint32_t horizon_code(uint64_t codes, uint32_t sector) { return codes >> (4 * sector) & 15; }

// Whether some sector has the code kHorizonNever.
inline bool has_never(uint64_t codes) {
  return (codes & codes >> 1 & codes >> 2 & codes >> 3 & 0x1111111111111111u) != 0;
}

// Whether a direction is above the horizon.
inline bool is_above(const HorizonFrame& f, const float (&direction)[3], uint64_t codes,
                     const float (&slope)[kHorizonSlopes]) {
  const float size = horizon::greatest(direction);
  if (!(size >= horizon::kShortest && size <= horizon::kLongest)) return false;
  const float u = horizon::along(f.x, direction), v = horizon::along(f.y, direction),
              w = horizon::along(f.n, direction);
  const float flat = u * u + v * v, up = w * w;
  if (!(w > 0)) return false;
  if (flat < horizon::kUpright * up) return !has_never(codes);
  const float k = slope[horizon_code(codes, horizon_sector(u, v))];
  return up >= k * k * flat;
}

// Corner k of triangle i of a leaf, whatever the file says.
template <uint32_t kVertices>
inline void corner_of(const HierarchyLeaf<kVertices>& leaf, uint32_t triangle, uint32_t k, float (&corner)[3]) {
  const uint32_t v = leaf.corner[k][triangle] % kVertices;
  for (uint32_t a = 0; a < 3; ++a) corner[a] = leaf.vertex[a][v];
}

// The corners of a place in the order of its side.
inline void corners_at(const HierarchyView& hierarchy, uint32_t place, float (&p)[3], float (&q)[3], float (&r)[3]) {
  const uint32_t i = triangle_of(place), turned = place >> 31;
  with_leaf(hierarchy, leaf_of(place), [&](const auto& leaf) {
    corner_of(leaf, i, 0, p), corner_of(leaf, i, 1 + turned, q), corner_of(leaf, i, 2 - turned, r);
  });
}

inline bool frame_at(const HierarchyView& hierarchy, uint32_t place, HorizonFrame& frame) {
  float p[3], q[3], r[3];
  corners_at(hierarchy, place, p, q, r);
  return make_horizon_frame(p, q, r, frame);
}

inline uint64_t codes_of(const HorizonEntry& entry) {
  uint64_t codes;
  std::memcpy(&codes, entry.codes, sizeof codes);
  return codes;
}

// The rule: whether the section proves that no triangle of the object meets the segment. primitive: of the source, that
// the segment begins on; any number and any bits may stand in both.
inline bool clear_of_horizon(const HorizonView& view, const HierarchyView& hierarchy, const Segment& segment,
                             uint32_t primitive) {
  if (primitive >= view.header().entries) return false;
  const HorizonEntry& entry = view.entries()[primitive];
  HorizonFrame frame;
  return frame_at(hierarchy, entry.place, frame) && begins_above(frame, segment) &&
         is_above(frame, segment.direction, codes_of(entry), view.header().slope[table_of(entry.place)]);
}

}  // namespace vcd
