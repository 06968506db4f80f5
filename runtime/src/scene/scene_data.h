// What queries of a scene need.
#pragma once

#include <cstdint>
#include <vector>

#include "lookup/kernels.h"
#include "lookup/to_grid.h"
#include "scene/boxes.h"

namespace vcd {

struct SceneData {
  std::vector<SceneNode> nodes;  // the first is the root; none: no instances
  // By instance.
  std::vector<ToGrid> to_grid;
  std::vector<ToFrame> to_frame;
  std::vector<LookUp> objects;  // tree null: without a sidecar that answers
  std::vector<uint32_t> masks;  // 0: absent
};

}  // namespace vcd
