#include <vcd/runtime/scene.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <new>
#include <string>

#include "lookup/object_data.h"
#include "scene/build_hierarchy.h"
#include "scene/pairs.h"
#include "scene/scene_state.h"
#include "scene/trace.h"

namespace vcd {

namespace {

ReachBox box_of(const SceneNode& root) {
  float min[3], max[3];
  for (int a = 0; a < 3; ++a) {
    min[a] = *std::ranges::min_element(root.side[0][a]);
    max[a] = *std::ranges::max_element(root.side[1][a]);
  }
  return reach_box(min, max);
}

}  // namespace

void Scene::State::set(std::span<const Transform> to_world) {
  std::vector<Placed> placed;
  const auto boxes_of = [&](size_t i) {
    const auto found = boxes.find(data.instances[i].object);
    return found == boxes.end() ? nullptr : &found->second;
  };
  for (size_t i = 0; i < instances.size(); ++i) placed.push_back(place(instances[i], boxes_of(i), to_world[i]));
  std::vector<Transform> kept(to_world.begin(), to_world.end());
  data.nodes = build_hierarchy(placed, [&](uint32_t i) {  // the last that can fail
    const MeshBoxes* const of = boxes_of(i);
    return of ? boxes_in_world(placed[i], *of, to_world[i]) : std::vector<WorldBox>();
  });
  data.box = data.nodes.empty() ? ReachBox{} : box_of(data.nodes[0]);
  data.to_world = std::move(kept);
  has_hierarchies = true;
  for (size_t i = 0; i < placed.size(); ++i) {
    const Placed& one = placed[i];
    instances[i].to_world = to_world[i];
    InstanceData& instance = data.instances[i];
    instance.to_grid = one.to_grid;
    instance.mask = one.absent ? 0 : instances[i].mask;  // so that nobody asks
    has_hierarchies &= one.absent || (instance.object && instance.object->traced.view);
    uses[i] = one.absent                                          ? InstanceUse::absent
              : has_inverse(one.to_grid) && data.look_ups[i].tree ? InstanceUse::asked
                                                                  : InstanceUse::left;
  }
}

SceneInstance SceneInstance::of(Object object, const Transform& to_world) {
  SceneInstance instance{object, {}, {}, to_world};
  std::copy_n(object.record().box_min, 3, instance.box_min);
  std::copy_n(object.record().box_max, 3, instance.box_max);
  return instance;
}

Scene::Scene(std::unique_ptr<State> state) : state_(std::move(state)) {}
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;
Scene::~Scene() = default;
size_t Scene::size() const noexcept { return state_->instances.size(); }
uint32_t Scene::mask(uint32_t instance) const noexcept { return state_->data.instances[instance].mask; }
bool Scene::clear_of_self(const Segment& segment, const SceneQuery& query) const noexcept {
  return vcd::clear_of_self(state_->data, begin_of(query, 0), segment);
}
bool Scene::has_hierarchies() const noexcept { return state_->has_hierarchies; }
bool Scene::occluded(const Segment& segment, const SceneQuery& query) const noexcept {
  return state_->kernels->occluded_in_scene(state_->data, segment, query);
}
InstanceUse Scene::use(uint32_t instance) const noexcept {
  assert(instance < size());
  return state_->uses[instance];
}

Result<Scene> Scene::build(std::span<const SceneInstance> instances, const std::string& kernel) try {
  auto state = std::make_unique<State>();
  state->kernels = kernels_named(kernel);
  if (!state->kernels)
    return Error{ErrorCode::usage, "kernel \"" + kernel + "\": this processor has none of that name"};
  state->instances.assign(instances.begin(), instances.end());
  std::vector<Transform> transforms;
  for (SceneInstance& instance : state->instances) {
    if (!instance.object) pad_box(instance);
    const TreeView* tree = instance.object && instance.object->answers() ? &instance.object->data_->tree : nullptr;
    const TreeKernels* at_depth =
        tree ? &kernels_for(*tree, *state->kernels).at_depth[instance.object->record().depth - 1u] : nullptr;
    state->data.look_ups.push_back({tree, at_depth});
    transforms.push_back(instance.to_world);
    InstanceData& data = state->data.instances.emplace_back();
    data.object = instance.object ? instance.object->data_ : nullptr;
    if (data.object && data.object->traced.view && !state->boxes.contains(data.object))
      state->boxes.emplace(data.object, mesh_boxes(*data.object->record, data.object->traced));
    data.look_up_one = data.object && data.object->look_up_in_scene;
    data.look_up_bundles = data.object && data.object->look_up_bundles[static_cast<size_t>(From::outside)];
    for (int a = 0; a < 3; ++a) {
      data.to_frame.unit[a] = (instance.box_max[a] - instance.box_min[a]) / kGrid;
      data.to_frame.min[a] = instance.box_min[a];
    }
  }
  state->uses.resize(instances.size());
  state->set(transforms);
  return Scene(std::move(state));
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "scene: out of memory"};
}

std::optional<Error> Scene::set_transforms(std::span<const Transform> to_world) try {
  if (to_world.size() != size())
    return Error{ErrorCode::usage, "scene: " + std::to_string(to_world.size()) + " transforms for " +
                                       std::to_string(size()) + " instances"};
  state_->set(to_world);
  return std::nullopt;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "scene: out of memory"};
}

Visibility Scene::classify(const Segment& segment, const SceneQuery& query) const noexcept {
  Visibility answer = Visibility::clear;
  state_->kernels->scene_segments(state_->data, std::span(&segment, 1), query, {&answer, nullptr});
  return answer;
}

void Scene::classify(std::span<const Segment> segments, std::span<Visibility> answers,
                     const SceneQuery& query) const noexcept {
  assert(answers.size() >= segments.size());
  std::fill_n(answers.begin(), segments.size(), Visibility::clear);
  state_->kernels->scene_segments(state_->data, segments, query, {answers.data(), nullptr});
}

std::optional<Segment> Scene::in_object(uint32_t instance, const Segment& segment) const noexcept {
  assert(instance < size());
  return vcd::in_object(state_->data, instance, segment);
}

Scene::Listed Scene::classify(std::span<const Segment> segments, std::span<Visibility> answers,
                              std::span<UnclassifiedPair> list, const SceneQuery& query) const noexcept {
  assert(answers.size() >= segments.size());
  std::fill_n(answers.begin(), segments.size(), Visibility::clear);
  UnclassifiedList found{list};
  state_->kernels->scene_segments(state_->data, segments, query, {answers.data(), &found});
  // Some of them were blocked by a later instance.
  const auto kept = list.first(found.count);
  const auto end = std::remove_if(kept.begin(), kept.end(),
                                  [&](const UnclassifiedPair& p) { return answers[p.segment] == Visibility::blocked; });
  std::sort(kept.begin(), end, [](const UnclassifiedPair& a, const UnclassifiedPair& b) {
    return a.segment != b.segment ? a.segment < b.segment
           : a.length != b.length ? a.length > b.length
                                  : a.instance < b.instance;
  });
  return {static_cast<size_t>(end - kept.begin()), found.complete};
}

}  // namespace vcd
