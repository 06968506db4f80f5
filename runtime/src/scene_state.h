// What a Scene holds.
#pragma once

#include <deque>
#include <optional>
#include <span>
#include <vector>

#include <vcd/runtime/scene.h>

#include "kernels.h"
#include "object_data.h"
#include "scene_data.h"

namespace vcd {

struct Scene::State {
  SceneData data;
  std::vector<SceneInstance> instances;
  std::deque<ObjectData> in_grid;  // one for each object that answers; data.objects points at them
  SceneKernels kernels;

  std::optional<Error> set(std::span<const Transform> to_world);
};

}  // namespace vcd
