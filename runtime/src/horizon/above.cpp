#include "horizon/above.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vcd {
namespace {

constexpr uint32_t kSmallUnits = sizeof(SmallLeaf) / kUnitBytes;

// corners_at(), of small and large leaves alike: those of V vertices hold x of all of them, then y, then z, then the
// first corners of 16 triangles, then the second, then the third.
void load_corners(const HierarchyView& hierarchy, uint32_t place, float (&p)[3], float (&q)[3], float (&r)[3]) {
  const uint32_t vertices = place & kPlaceLarge ? kLargeVertices : kNodeWidth;
  const std::byte* const leaf = hierarchy.units + size_t{place & kPlaceUnitMask} * kUnitBytes;
  for (uint32_t unit = 0; unit < kSmallUnits; ++unit) __builtin_prefetch(leaf + unit * kUnitBytes);  // corners and all
  const auto* const x = reinterpret_cast<const float*>(leaf);
  const auto* const corner = reinterpret_cast<const uint8_t*>(leaf) + 12 * vertices + triangle_of(place);
  const uint32_t turned = place >> 31, mask = vertices - 1;
  const uint32_t i = corner[0] & mask, j = corner[kNodeWidth * (1 + turned)] & mask,
                 k = corner[kNodeWidth * (2 - turned)] & mask;
  for (uint32_t a = 0; a < 3; ++a) p[a] = x[a * vertices + i], q[a] = x[a * vertices + j], r[a] = x[a * vertices + k];
}
static_assert(offsetof(SmallLeaf, corner) == 12 * kNodeWidth && offsetof(LargeLeaf, corner) == 12 * kLargeVertices);

// begins_above(), all of it.
bool begins(const HorizonFrame& f, const Segment& s) {
  float r[3];
  const float near = horizon::kNear * f.size;
  bool good = true;
  for (int i = 0; i < 3; ++i) {
    const float moved = s.t_min * s.direction[i];
    r[i] = s.origin[i] - f.corner[i];
    good &= std::fabs(r[i]) <= near;
    good &= std::fabs(moved) <= near;
    r[i] += moved;
  }
  const float u = horizon::along(f.x, r), v = horizon::along(f.y, r), w = horizon::along(f.n, r);
  good &= w - f.top >= horizon::kLowest * f.size;
  const float inside = horizon::kInside * f.size * f.size;
  for (int i = 0; i < 3; ++i) {
    const int j = i == 2 ? 0 : i + 1;
    good &= (f.u[j] - f.u[i]) * (v - f.v[i]) - (f.v[j] - f.v[i]) * (u - f.u[i]) >= inside;
  }
  return good;
}

// horizon_sector(): what is taken from 3, 7 or 15 there has no other bits.
uint32_t sector_of(float u, float v) {
  const float a = std::fabs(u), b = std::fabs(v);
  const auto some = [](bool condition, uint32_t bits) { return (0u - uint32_t{condition}) & bits; };
  return some(std::min(a, b) > horizon::kTan * std::max(a, b), 1) ^ some(b > a, 3) ^ some(u < 0, 7) ^ some(v < 0, 15);
}

}  // namespace

bool is_clear(const Horizons& horizons, const Segment& segment, uint32_t primitive) noexcept {
  if (!horizons.view || primitive >= horizons.view.header().entries) return false;
  const HorizonEntry& entry = horizons.view.entries()[primitive];
  float p[3], q[3], r[3];
  load_corners(horizons.hierarchy, entry.place, p, q, r);
  HorizonFrame f;
  if (!make_horizon_frame(p, q, r, f)) return false;
  const uint64_t codes = codes_of(entry);
  const auto& d = segment.direction;
  const float size = horizon::greatest(d);
  const float u = horizon::along(f.x, d), v = horizon::along(f.y, d), w = horizon::along(f.n, d);
  const float flat = u * u + v * v, up = w * w;
  const float k = horizons.view.header().slope[table_of(entry.place)][horizon_code(codes, sector_of(u, v))];
  const bool upright = flat < horizon::kUpright * up, steep = up >= k * k * flat;
  const bool above = (upright & !has_never(codes)) | (!upright & steep);
  return begins(f, segment) & (size >= horizon::kShortest) & (size <= horizon::kLongest) & (w > 0) & above;
}

SampleBits above_array_scalar(const Horizons& horizons, const Segment* segments, const uint32_t* primitives,
                              size_t count) noexcept {
  SampleBits clear{};
  for (size_t i = 0; i < count; ++i)
    clear.set(i, clear_of_horizon(horizons.view, horizons.hierarchy, segments[i], primitives[i]));
  return clear;
}

SampleBits above_fan_scalar(const Horizons& horizons, const Fan& fan, uint32_t primitive) noexcept {
  SampleBits clear{};
  for (size_t i : fan.live)
    clear.set(i, clear_of_horizon(horizons.view, horizons.hierarchy, segment_of(fan, i), primitive));
  return clear;
}

}  // namespace vcd
