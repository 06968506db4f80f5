// What queries of a scene need.
#pragma once

#include <cstdint>
#include <vector>

#include <vcd/runtime/scene.h>

#include "lookup/kernels.h"
#include "lookup/to_grid.h"
#include "scene/boxes.h"

namespace vcd {

struct ObjectData;

struct SceneData {
  std::vector<SceneNode> nodes;  // the first is the root; none: no instances
  // By instance.
  std::vector<ToGrid> to_grid;
  std::vector<ToFrame> to_frame;
  std::vector<LookUp> objects;              // tree null: without a sidecar that answers
  std::vector<const ObjectData*> sidecars;  // null: none
  std::vector<uint8_t> look_up_first;       // whether to look up before the hierarchy is asked
  std::vector<Transform> to_world;
  std::vector<uint32_t> masks;  // 0: absent
};

}  // namespace vcd
