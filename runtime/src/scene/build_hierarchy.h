// The hierarchy over the instances' boxes.
#pragma once

#include <span>
#include <vector>

#include "scene/boxes.h"
#include "scene/placement.h"

namespace vcd {

// Eight boxes a node: the instances of a node are split in halves along the longest axis of their centres, three times.
// The first node is the root; none where there are no instances.
std::vector<SceneNode> build_hierarchy(std::span<const Placed> placed);

}  // namespace vcd
