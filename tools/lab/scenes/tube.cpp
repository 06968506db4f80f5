#include "tube.h"

namespace vcd::scenes {
namespace {

Double3 direction_at(std::span<const PathPoint> path, size_t i) {
  const size_t before = i == 0 ? 0 : i - 1, after = i + 1 == path.size() ? i : i + 1;
  const Double3 chord = path[after].at - path[before].at;
  return dot(chord, chord) > 0 ? unit(chord) : unit(path[i].at - path[before].at);  // a path that turns right back
}

// Carries `side` on to the next ring with as little turning about the axis as possible, so that the tube does not
// twist.
Double3 carried(Double3 side, Double3 axis) {
  const Double3 flat = side - dot(side, axis) * axis;
  return dot(flat, flat) > 1e-6 ? unit(flat) : across(axis).side;
}

}  // namespace

void append_tube(Mesh& mesh, std::span<const PathPoint> path, uint32_t sides) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  Double3 side = across(direction_at(path, 0)).side;
  for (size_t i = 0; i < path.size(); ++i) {
    const Double3 axis = direction_at(path, i);
    side = carried(side, axis);
    const Double3 forth = cross(axis, side);
    for (uint32_t k = 0; k < sides; ++k) {
      const CosSin t = at_turn(static_cast<double>(k) / sides);
      mesh.positions.push_back(on_grid(path[i].at + path[i].radius * (t.cos * side + t.sin * forth)));
    }
  }
  for (uint32_t ring = 0; ring + 1 < path.size(); ++ring) {
    for (uint32_t k = 0; k < sides; ++k) {
      const uint32_t a = first + ring * sides + k, b = first + ring * sides + (k + 1) % sides;
      mesh.triangles.push_back({a, b, a + sides});
      mesh.triangles.push_back({b, b + sides, a + sides});
    }
  }
}

}  // namespace vcd::scenes
