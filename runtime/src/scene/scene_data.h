// What queries of a scene need.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <vcd/runtime/scene.h>

#include "hierarchy/traced.h"
#include "lookup/kernels.h"
#include "lookup/to_grid.h"
#include "scene/boxes.h"

namespace vcd {

struct ObjectData;

// An instance, in two cache lines.
struct alignas(64) InstanceData {
  ToGrid to_grid;
  ToFrame to_frame;
  const ObjectData* object;           // null: no sidecar
  uint32_t mask;                      // 0: absent
  bool look_up_one, look_up_bundles;  // before the hierarchy is asked: segments one by one, arrays too, and bundles
};
static_assert(sizeof(InstanceData) == 128);

struct SceneData {
  std::vector<SceneNode> nodes;  // the first is the root; none: no instances
  ReachBox box;                  // of the root
  // By instance.
  std::vector<InstanceData> instances;
  std::vector<LookUp> look_ups;  // tree null: without a sidecar that answers
  std::vector<Transform> to_world;
};

}  // namespace vcd
