// Trees of four species, grown rather than drawn.
#pragma once

#include <cstdint>

#include <vcd/scenes/scene.h>

namespace vcd::scenes {

enum class Species { broadleaf, conifer, birch, shrub };
inline constexpr uint32_t kSpeciesCount = 4;

// One tree with about so many leaves (of the conifer: sprays of needles), two triangles each. It stands at the origin,
// y up, in metres: 12, 14, 13 and 2.5 high. Fewer leaves are larger leaves, so that the crown stays as dense.
Mesh grow_tree(Species species, uint32_t leaves, uint64_t seed);

uint64_t tree_triangles_bound(uint32_t leaves);  // of any species, at most

}  // namespace vcd::scenes
