// A light of a scene file, in the scene's frame.
#pragma once

#include <array>
#include <cstdint>

namespace vcd::baker {

struct SceneLight {
  using Vector = std::array<double, 3>;
  enum class Shape : uint64_t {
    point,        // from a position to all sides, or into a cone
    directional,  // along a direction, from infinitely far away
    rectangle,    // from a rectangle to the side that the direction points to
    sky,          // from all directions above the ground
  };

  Shape shape = Shape::point;
  Vector position = {};                   // of a point, or of the middle of a rectangle
  Vector direction = {0, 0, -1};          // that light travels: directional, rectangle, and the axis of a cone; unit
  double cone_cosine = -1;                // point: of the angle to the axis up to which there is light; -1: all sides
  double range = 0;                       // point: as far as there is light; 0: any distance
  std::array<Vector, 2> half_edges = {};  // rectangle: from its middle to the middles of two sides

  bool operator==(const SceneLight&) const = default;
};

}  // namespace vcd::baker
