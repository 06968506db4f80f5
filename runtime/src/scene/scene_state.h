// What a Scene holds.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include <vcd/runtime/scene.h>

#include "lookup/kernels.h"
#include "scene/placement.h"
#include "scene/scene_data.h"

namespace vcd {

struct Scene::State {
  SceneData data;
  std::vector<SceneInstance> instances;
  std::vector<InstanceUse> uses;
  std::map<const ObjectData*, MeshBoxes> boxes;  // of the objects with a hierarchy
  const Kernels* kernels;

  // As many as instances.
  void set(std::span<const Transform> to_world);
  // Whether all instances that are not absent have a hierarchy.
  bool has_hierarchies = true;
};

}  // namespace vcd
