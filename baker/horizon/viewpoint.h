// One side of a triangle, and how far the rest of the mesh rises above it: spec/proofs.md, "Horizons".
#pragma once

#include <array>
#include <cstdint>

#include <vcd/format/horizon.h>
#include <vcd/format/meets.h>

#include "horizon/levels.h"

namespace vcd::baker {

// Segments begin above the triangle, at least so far, in its frame's size: half of what begins_above() asks.
inline constexpr double kLowestBegin = 0.5 * horizon::kLowest;

// The middles of the sectors, as unit vectors.
inline constexpr std::array<double, kHorizonSectors> kMiddleU = [] {
  constexpr double kFirst[] = {0.98078528040323043, 0.83146961230254524, 0.55557023301960218, 0.19509032201612825};
  std::array<double, kHorizonSectors> u{};
  for (size_t s = 0; s < 4; ++s) u[s] = u[15 - s] = kFirst[s], u[7 - s] = u[8 + s] = -kFirst[s];
  return u;
}();
inline constexpr std::array<double, kHorizonSectors> kMiddleV = [] {
  std::array<double, kHorizonSectors> v{};
  for (size_t s = 0; s < kHorizonSectors; ++s) v[s] = kMiddleU[(s + 12) % kHorizonSectors];
  return v;
}();

// Corners of an occluder or of the triangle itself, seen in the frame: along x, y and n, from corner 0.
struct Seen {
  double u, v, w;
};

class Viewpoint {
 public:
  // reach: the greatest absolute coordinate of the mesh.
  Viewpoint(const HorizonFrame& frame, const Triangle& corners, float reach);

  // False where the mesh is too large for so small a triangle: then nothing can be said of it.
  bool usable() const { return usable_; }

  // Raises the levels of the sectors in `which`, a bit each, that a triangle is seen in, until no point of it that a
  // segment could meet is steeper. Returns the sectors raised.
  uint32_t raise(const Triangle& occluder, uint32_t which, Levels& levels) const;

  const HorizonFrame& frame() const { return frame_; }
  // The triangle seen from above: the middle of a circle around it, and its corners from there; rounded.
  float middle_u() const { return middle_u_; }
  float middle_v() const { return middle_v_; }
  float radius() const { return radius_; }
  const std::array<std::array<float, 2>, 3>& around() const { return around_; }
  float base() const { return static_cast<float>(base_); }  // along n, of the lowest begin; rounded

 private:
  Seen see(const std::array<float, 3>& point) const;

  const HorizonFrame& frame_;
  std::array<Seen, 3> corners_;
  double base_, error_;
  float middle_u_, middle_v_, radius_;
  std::array<std::array<float, 2>, 3> around_;
  bool usable_;
};

}  // namespace vcd::baker
