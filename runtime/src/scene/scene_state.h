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
  std::vector<InstanceUse> uses;
  const Kernels* kernels;

  // As many as instances.
  void set(std::span<const Transform> to_world);
  // Whether all instances that are not absent have a hierarchy.
  bool has_hierarchies = true;
};

}  // namespace vcd
