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

// Streams pay somewhere from here on. Of a path tracer's rays in a forest, on a processor with 1 MiB of second-level
// cache: with 2.7 MB of hierarchies 355 ns by streams and 317 without, with 19 MB 390 to 430 and 470 to 600.
inline constexpr size_t kStreamBytes = size_t{4} << 20;

struct SceneData {
  std::vector<SceneNode> nodes;  // the first is the root; none: no instances
  ReachBox box;                  // of the root
  bool streams = false;  // arrays: many segments on their way at once, as the hierarchies have kStreamBytes or more
  // By instance.
  std::vector<ToGrid> to_grid;
  std::vector<ToFrame> to_frame;
  std::vector<LookUp> objects;              // tree null: without a sidecar that answers
  std::vector<const ObjectData*> sidecars;  // null: none
  // Whether to look up before the hierarchy is asked: segments one by one, arrays too, and bundles.
  std::vector<uint8_t> look_up_one, look_up_bundles;
  std::vector<Transform> to_world;
  std::vector<uint32_t> masks;  // 0: absent
};

}  // namespace vcd
