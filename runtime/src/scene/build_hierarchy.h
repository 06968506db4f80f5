// The hierarchy over the instances' boxes.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "scene/boxes.h"
#include "scene/placement.h"

namespace vcd {

// The first node is the root; none where there are no instances. A node's instances are split in two, and the part with
// the greatest surface again, until it has sixteen: by the surface-area heuristic over bins of middles (Wald, "On fast
// construction of SAH-based bounding volume hierarchies", 2007). Deep in the hierarchy, and where boxes are infinite,
// they are halved by number, so that no path is longer than kMostSceneLevels.
//
// Where one node holds all instances and has room left, an instance whose boxes_of(instance) are smaller together than
// its one box has several, side by side: fewer segments then come to it that pass it by. Elsewhere that gained nothing.
using BoxesOf = std::function<std::vector<WorldBox>(uint32_t instance)>;
std::vector<SceneNode> build_hierarchy(std::span<const Placed> placed, const BoxesOf& boxes_of);

}  // namespace vcd
