// What a Scene holds.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <vcd/runtime/scene.h>

#include "lookup/kernels.h"
#include "scene/scene_data.h"

namespace vcd {

struct Scene::State {
  SceneData data;
  std::vector<SceneInstance> instances;
  const Kernels* kernels;

  std::optional<Error> set(std::span<const Transform> to_world);
};

}  // namespace vcd
