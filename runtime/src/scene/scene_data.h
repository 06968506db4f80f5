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

// Streams pay from here on. Times faster than Embree's packets, of a path tracer's wavefronts on a processor with 1 MiB
// of second-level cache: with 1.5 MB of hierarchies 1.00 by streams and 1.12 without, with 15 MB 1.5 and 1.2.
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
  std::vector<uint8_t> look_up_first;       // whether to look up before the hierarchy is asked
  std::vector<Transform> to_world;
  std::vector<uint32_t> masks;  // 0: absent
};

}  // namespace vcd
