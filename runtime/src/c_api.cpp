#include <cassert>
#include <cstring>
#include <map>
#include <mutex>
#include <new>
#include <string>
#include <vector>

#include <vcd/runtime/counting.h>
#include <vcd/runtime/from_c.h>
#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>
#include <vcd/runtime/sidecar_store.h>
#include <vcd/runtime/vcd.h>

#include "lookup/kernels.h"

// Handles: vcd_sidecar is a vcd::Sidecar with one vcd::Object for each of its objects, whose addresses are the
// vcd_object handles.
struct vcd_object {
  vcd::Object object;
};
struct vcd_sidecar {
  vcd::Sidecar sidecar;
  std::vector<vcd_object> objects;
};
struct vcd_scene {
  vcd::Scene scene;
};
struct vcd_store {
  vcd::SidecarStore store;
  std::mutex mutex = {};  // of the handles
  std::map<const vcd::ObjectRecord*, vcd_object> objects = {};
};

static_assert(sizeof(vcd::Visibility) == 1);
static_assert(static_cast<int>(vcd::From::outside) == VCD_FROM_OUTSIDE &&
              static_cast<int>(vcd::From::inside) == VCD_FROM_INSIDE &&
              static_cast<int>(vcd::From::self) == VCD_FROM_SELF);
static_assert(static_cast<int>(vcd::InstanceUse::asked) == VCD_INSTANCE_ASKED &&
              static_cast<int>(vcd::InstanceUse::left) == VCD_INSTANCE_LEFT &&
              static_cast<int>(vcd::InstanceUse::absent) == VCD_INSTANCE_ABSENT);

namespace {

using vcd::in_c::fail;
using vcd::in_c::is_whole;
using vcd::in_c::size_of;
using vcd::in_c::translate;

vcd::OpenOptions translate(const vcd_open_options* options) {
  vcd::OpenOptions result;
  if (!options) return result;
  if (options->copy) result.load = vcd::Load::copy;
  if (options->check == VCD_CHECK_BOUNDS) result.check = vcd::CheckLevel::bounds;
  if (options->check == VCD_CHECK_CANONICAL) result.check = vcd::CheckLevel::canonical;
  result.proven_only = options->proven_only != 0;
  if (options->kernel) result.kernel = options->kernel;
  if (options->look_up == VCD_LOOK_UP_ALWAYS) result.look_up = vcd::LookUpFirst::always;
  if (options->look_up == VCD_LOOK_UP_NEVER) result.look_up = vcd::LookUpFirst::never;
  return result;
}

vcd_result finish(vcd::Result<vcd::Sidecar> opened, const vcd_sidecar** out, vcd_error* error) {
  if (!opened) return fail(error, opened.error());
  try {
    auto* handle = new vcd_sidecar{std::move(*opened), {}};
    *out = handle;
    for (size_t i = 0; i < handle->sidecar.object_count(); ++i) handle->objects.push_back({handle->sidecar.object(i)});
    return VCD_SUCCESS;
  } catch (const std::bad_alloc&) {
    delete *out;
    *out = nullptr;
    return fail(error, VCD_ERROR_RUNTIME, "out of memory");
  }
}

bool usable(const vcd_open_options* options) {
  return !options ||
         (is_whole(*options) && options->check >= VCD_CHECK_CHECKSUMS && options->check <= VCD_CHECK_CANONICAL &&
          options->look_up >= VCD_LOOK_UP_AS_BAKED && options->look_up <= VCD_LOOK_UP_NEVER);
}
constexpr const char* kWrongOptions = "options: their size, check or look_up is none that this library knows";

uint32_t mask_of(uint32_t in_c) { return in_c == 0 ? 0xFFFFFFFF : in_c; }

vcd::SceneInstance translate(const vcd_instance& from) {
  vcd::Transform to_world;
  std::memcpy(&to_world, from.to_world, sizeof to_world);
  vcd::SceneInstance instance{std::nullopt, {}, {}, to_world};
  if (from.object) {
    instance = vcd::SceneInstance::of(from.object->object, to_world);
  } else {
    std::memcpy(instance.box_min, from.box_min, sizeof instance.box_min);
    std::memcpy(instance.box_max, from.box_max, sizeof instance.box_max);
  }
  instance.mask = mask_of(from.mask);
  return instance;
}

vcd::GeometryHash hash_of(const uint8_t bytes[16]) {
  vcd::GeometryHash hash;
  std::memcpy(hash.data(), bytes, hash.size());
  return hash;
}

void add(vcd_answer_counts* counts, const vcd::AnswerCounts& more) {
  counts->clear += more.clear, counts->blocked += more.blocked, counts->unclassified += more.unclassified;
}

template <class Bundle>
void occluded(const vcd_object* object, const Bundle& bundle, vcd_from from, uint64_t* blocked) {
  object->object.occluded(translate(bundle), {blocked, (bundle.count + 63) / 64}, static_cast<vcd::From>(from));
}

vcd::SceneQuery translate(const vcd_scene_query* query, size_t origins) {
  if (!query) return {};
  assert(is_whole(*query));
  const auto all = [&](const uint32_t* of) { return of ? std::span(of, origins) : std::span<const uint32_t>{}; };
  return {mask_of(query->mask), all(query->origins), all(query->primitives)};
}

// The caller's function, as a Scene asks it.
struct Trace {
  vcd_trace_unclassified trace;
  void* context;
  void operator()(const vcd::UnclassifiedSegments& left) const {
    const auto& [origin, t_min, direction, t_max, count] = left.segments;
    const vcd_unclassified_segments in_c = {
        sizeof in_c,
        left.instance,
        left.in_world,
        {{origin[0], origin[1], origin[2]}, t_min, {direction[0], direction[1], direction[2]}, t_max, count},
        left.indices,
        left.blocked};
    trace(context, &in_c);
  }
};

// asked: segments or a bundle.
template <class Asked>
void occluded(const vcd::Scene& scene, const Asked& asked, vcd_trace_unclassified trace, void* context,
              uint64_t* blocked, const vcd::SceneQuery& query) {
  const std::span<uint64_t> bits(blocked, (asked.size() + 63) / 64);
  if (trace) scene.occluded(asked, bits, Trace{trace, context}, query);
  else scene.occluded(asked, bits, query);
}

const vcd_object* handle_of(const vcd_sidecar* sidecar, const std::optional<vcd::Object>& found) {
  if (!found) return nullptr;
  for (const vcd_object& object : sidecar->objects)
    if (&object.object.record() == &found->record()) return &object;
  return nullptr;
}

}  // namespace

extern "C" {

const char* vcd_result_string(vcd_result result) {
  switch (result) {
    case VCD_SUCCESS: return "success";
    case VCD_ERROR_USAGE: return "wrong argument";
    case VCD_ERROR_IO: return "input or output failed";
    case VCD_ERROR_INVALID_FILE: return "invalid file";
    case VCD_ERROR_RUNTIME: return "out of memory";
    case VCD_ERROR_UNSUPPORTED: return "unsupported version or section";
  }
  return "unknown result";
}

const char* vcd_kernel(size_t index) try {
  const auto kernels = vcd::usable_kernels();
  return index < kernels.size() ? kernels[index]->name : nullptr;
} catch (...) {
  return nullptr;
}

vcd_result vcd_open(const char* path, const vcd_open_options* options, const vcd_sidecar** sidecar,
                    vcd_error* error) try {
  if (!sidecar) return fail(error, VCD_ERROR_USAGE, "sidecar is null");
  *sidecar = nullptr;
  if (!path) return fail(error, VCD_ERROR_USAGE, "path is null");
  if (!usable(options)) return fail(error, VCD_ERROR_USAGE, kWrongOptions);
  return finish(vcd::Sidecar::open(path, translate(options)), sidecar, error);
} catch (...) {
  return VCD_ERROR_RUNTIME;
}

vcd_result vcd_open_buffer(const void* data, size_t size, const vcd_open_options* options, const vcd_sidecar** sidecar,
                           vcd_error* error) try {
  if (!sidecar) return fail(error, VCD_ERROR_USAGE, "sidecar is null");
  *sidecar = nullptr;
  if (!data && size) return fail(error, VCD_ERROR_USAGE, "data is null");
  if (!usable(options)) return fail(error, VCD_ERROR_USAGE, kWrongOptions);
  const vcd::Bytes bytes(static_cast<const std::byte*>(data), size);
  return finish(vcd::Sidecar::open_buffer(bytes, translate(options)), sidecar, error);
} catch (...) {
  return VCD_ERROR_RUNTIME;
}

void vcd_close(const vcd_sidecar* sidecar) { delete sidecar; }

size_t vcd_object_count(const vcd_sidecar* sidecar) { return sidecar->objects.size(); }

const vcd_object* vcd_object_at(const vcd_sidecar* sidecar, size_t index) {
  return index < sidecar->objects.size() ? &sidecar->objects[index] : nullptr;
}

const vcd_object* vcd_object_by_name(const vcd_sidecar* sidecar, const char* name) {
  return handle_of(sidecar, sidecar->sidecar.find(std::string_view(name)));
}

const vcd_object* vcd_object_by_hash(const vcd_sidecar* sidecar, const uint8_t hash[16]) {
  return handle_of(sidecar, sidecar->sidecar.find(hash_of(hash)));
}

vcd_result vcd_geometry_hash(const vcd_mesh_buffers* mesh, uint8_t hash[16], vcd_error* error) try {
  if (!mesh || !hash || !is_whole(*mesh)) return fail(error, VCD_ERROR_USAGE, "mesh or hash is null, or of no size");
  const vcd::PositionBuffer positions{mesh->positions, mesh->position_count,
                                      mesh->position_stride ? mesh->position_stride : sizeof(vcd::Position)};
  const vcd::IndexBuffer faces{mesh->indices, mesh->face_count, mesh->corners ? mesh->corners : 3,
                               mesh->index_size ? mesh->index_size : 4, mesh->index_stride};
  const auto found = vcd::geometry_hash(positions, faces);
  if (!found) return fail(error, found.error());
  std::memcpy(hash, found->data(), found->size());
  return VCD_SUCCESS;
} catch (...) {
  return VCD_ERROR_RUNTIME;
}

vcd_result vcd_store_open(const char* const* folders, size_t count, const vcd_open_options* options, vcd_store** store,
                          vcd_error* error) try {
  if (!store) return fail(error, VCD_ERROR_USAGE, "store is null");
  *store = nullptr;
  if (!folders && count) return fail(error, VCD_ERROR_USAGE, "folders is null");
  if (!usable(options)) return fail(error, VCD_ERROR_USAGE, kWrongOptions);
  const std::vector<std::filesystem::path> paths(folders, folders + count);
  auto opened = vcd::SidecarStore::open(paths, translate(options));
  if (!opened) return fail(error, opened.error());
  *store = new vcd_store{std::move(*opened)};
  return VCD_SUCCESS;
} catch (...) {
  return VCD_ERROR_RUNTIME;
}

void vcd_store_close(vcd_store* store) { delete store; }

vcd_result vcd_store_find(vcd_store* store, const uint8_t hash[16], const vcd_object** object, vcd_error* error) try {
  if (!store || !hash || !object) return fail(error, VCD_ERROR_USAGE, "store, hash or object is null");
  *object = nullptr;
  const auto found = store->store.find(hash_of(hash));
  if (!found) return fail(error, found.error());
  if (!*found) return VCD_SUCCESS;
  const std::lock_guard lock(store->mutex);
  *object = &store->objects.try_emplace(&(*found)->record(), vcd_object{**found}).first->second;
  return VCD_SUCCESS;
} catch (...) {
  return VCD_ERROR_RUNTIME;
}

size_t vcd_store_size(const vcd_store* store) { return store->store.size(); }

const char* vcd_store_passed_over(const vcd_store* store, size_t index) {
  const auto& errors = store->store.passed_over();
  return index < errors.size() ? errors[index].message.c_str() : nullptr;
}

const char* vcd_object_name(const vcd_object* object, size_t* length) {
  const std::string_view name = object->object.name();
  if (length) *length = name.size();
  return name.data();
}

int vcd_object_answers(const vcd_object* object) { return object->object.answers(); }

vcd_visibility vcd_classify(const vcd_object* object, const vcd_segment* segment) {
  return static_cast<vcd_visibility>(object->object.classify(translate(*segment)));
}

void vcd_classify_array(const vcd_object* object, const vcd_segment* segments, size_t count, uint8_t* answers) {
  object->object.classify(std::span(reinterpret_cast<const vcd::Segment*>(segments), count),
                          std::span(reinterpret_cast<vcd::Visibility*>(answers), count));
}

void vcd_classify_arrays(const vcd_object* object, const vcd_segment_arrays* segments, uint8_t* answers) {
  object->object.classify(translate(*segments),
                          std::span(reinterpret_cast<vcd::Visibility*>(answers), segments->count));
}

void vcd_classify_quad(const vcd_object* object, const vcd_quad_bundle* bundle, uint64_t* blocked,
                       uint64_t* unclassified) {
  const size_t words = (bundle->count + 63) / 64;
  object->object.classify(translate(*bundle), {blocked, words}, {unclassified, words});
}

void vcd_classify_sphere(const vcd_object* object, const vcd_sphere_bundle* bundle, uint64_t* blocked,
                         uint64_t* unclassified) {
  const size_t words = (bundle->count + 63) / 64;
  object->object.classify(translate(*bundle), {blocked, words}, {unclassified, words});
}

void vcd_count_answers(vcd_answer_counts* counts, const uint8_t* answers, size_t count) {
  vcd::AnswerCounts more;
  more.add(std::span(reinterpret_cast<const vcd::Visibility*>(answers), count));
  add(counts, more);
}

void vcd_count_bundle(vcd_answer_counts* counts, const uint64_t* blocked, const uint64_t* unclassified, size_t count) {
  const size_t words = (count + 63) / 64;
  vcd::AnswerCounts more;
  more.add(count, {blocked, words}, {unclassified, words});
  add(counts, more);
}

int vcd_object_has_horizons(const vcd_object* object) { return object->object.has_horizons(); }

vcd_visibility vcd_classify_self(const vcd_object* object, const vcd_segment* segment, uint32_t primitive) {
  return static_cast<vcd_visibility>(object->object.classify_self(translate(*segment), primitive));
}

void vcd_classify_self_array(const vcd_object* object, const vcd_segment* segments, const uint32_t* primitives,
                             size_t count, uint8_t* answers) {
  object->object.classify_self(std::span(reinterpret_cast<const vcd::Segment*>(segments), count), {primitives, count},
                               {reinterpret_cast<vcd::Visibility*>(answers), count});
}

int vcd_occluded_self(const vcd_object* object, const vcd_segment* segment, uint32_t primitive) {
  return object->object.occluded_self(translate(*segment), primitive);
}

void vcd_occluded_self_array(const vcd_object* object, const vcd_segment* segments, const uint32_t* primitives,
                             size_t count, uint64_t* blocked) {
  object->object.occluded_self(std::span(reinterpret_cast<const vcd::Segment*>(segments), count), {primitives, count},
                               {blocked, (count + 63) / 64});
}

void vcd_occluded_self_quad(const vcd_object* object, const vcd_quad_bundle* bundle, uint32_t primitive,
                            uint64_t* blocked) {
  object->object.occluded_self(translate(*bundle), primitive, {blocked, (bundle->count + 63) / 64});
}

void vcd_occluded_self_sphere(const vcd_object* object, const vcd_sphere_bundle* bundle, uint32_t primitive,
                              uint64_t* blocked) {
  object->object.occluded_self(translate(*bundle), primitive, {blocked, (bundle->count + 63) / 64});
}

void vcd_occluded_self_point(const vcd_object* object, const vcd_point_bundle* bundle, uint32_t primitive,
                             uint64_t* blocked) {
  object->object.occluded_self(translate(*bundle), primitive, {blocked, (bundle->count + 63) / 64});
}

int vcd_object_has_hierarchy(const vcd_object* object) { return object->object.has_hierarchy(); }

int vcd_occluded(const vcd_object* object, const vcd_segment* segment, vcd_from from) {
  return object->object.occluded(translate(*segment), static_cast<vcd::From>(from));
}

void vcd_occluded_array(const vcd_object* object, const vcd_segment* segments, size_t count, vcd_from from,
                        uint64_t* blocked) {
  object->object.occluded(std::span(reinterpret_cast<const vcd::Segment*>(segments), count),
                          {blocked, (count + 63) / 64}, static_cast<vcd::From>(from));
}

void vcd_occluded_quad(const vcd_object* object, const vcd_quad_bundle* bundle, vcd_from from, uint64_t* blocked) {
  occluded(object, *bundle, from, blocked);
}
void vcd_occluded_sphere(const vcd_object* object, const vcd_sphere_bundle* bundle, vcd_from from, uint64_t* blocked) {
  occluded(object, *bundle, from, blocked);
}
void vcd_occluded_point(const vcd_object* object, const vcd_point_bundle* bundle, vcd_from from, uint64_t* blocked) {
  occluded(object, *bundle, from, blocked);
}

vcd_result vcd_scene_build(const vcd_instance* instances, size_t count, const char* kernel, vcd_scene** scene,
                           vcd_error* error) try {
  if (!scene) return fail(error, VCD_ERROR_USAGE, "scene is null");
  *scene = nullptr;
  if (!instances && count) return fail(error, VCD_ERROR_USAGE, "instances is null");
  std::vector<vcd::SceneInstance> all;
  const size_t stride = count ? size_of(instances[0]) : 0;
  for (size_t i = 0; i < count; ++i) {
    vcd_instance from;
    const auto* at = reinterpret_cast<const std::byte*>(instances) + i * stride;
    std::memcpy(&from.size, at, sizeof from.size);
    if (!is_whole(from) || size_of(from) != stride)
      return fail(error, VCD_ERROR_USAGE,
                  "instance " + std::to_string(i) + ": its size is wrong, or not the first one's");
    std::memcpy(&from, at, sizeof from);
    all.push_back(translate(from));
  }
  auto built = vcd::Scene::build(all, kernel ? kernel : "");
  if (!built) return fail(error, built.error());
  *scene = new vcd_scene{std::move(*built)};
  return VCD_SUCCESS;
} catch (...) {
  return fail(error, VCD_ERROR_RUNTIME, "out of memory");
}

void vcd_scene_free(vcd_scene* scene) { delete scene; }

vcd_result vcd_scene_set_transforms(vcd_scene* scene, const float* to_world, vcd_error* error) {
  static_assert(sizeof(vcd::Transform) == 12 * sizeof(float));
  const std::span transforms(reinterpret_cast<const vcd::Transform*>(to_world), scene->scene.size());
  const auto refused = scene->scene.set_transforms(transforms);
  return refused ? fail(error, *refused) : VCD_SUCCESS;
}

vcd_instance_use vcd_scene_use(const vcd_scene* scene, uint32_t instance) {
  return static_cast<vcd_instance_use>(scene->scene.use(instance));
}

vcd_visibility vcd_scene_classify(const vcd_scene* scene, const vcd_segment* segment, uint32_t mask, uint32_t origin) {
  return static_cast<vcd_visibility>(
      scene->scene.classify(translate(*segment), {mask_of(mask), std::span(&origin, 1)}));
}

int vcd_scene_has_hierarchies(const vcd_scene* scene) { return scene->scene.has_hierarchies(); }

int vcd_scene_occluded_one(const vcd_scene* scene, const vcd_segment* segment, uint32_t mask, uint32_t origin) {
  return scene->scene.occluded(translate(*segment), {mask_of(mask), std::span(&origin, 1)});
}

int vcd_scene_occluded_self(const vcd_scene* scene, const vcd_segment* segment, uint32_t mask, uint32_t origin,
                            uint32_t primitive) {
  return scene->scene.occluded(translate(*segment), {mask_of(mask), std::span(&origin, 1), std::span(&primitive, 1)});
}

void vcd_scene_occluded(const vcd_scene* scene, const vcd_segment* segments, size_t count, const vcd_scene_query* query,
                        vcd_trace_unclassified trace, void* context, uint64_t* blocked) {
  occluded(scene->scene, std::span(reinterpret_cast<const vcd::Segment*>(segments), count), trace, context, blocked,
           translate(query, count));
}

void vcd_scene_occluded_quad(const vcd_scene* scene, const vcd_quad_bundle* bundle, const vcd_scene_query* query,
                             vcd_trace_unclassified trace, void* context, uint64_t* blocked) {
  occluded(scene->scene, translate(*bundle), trace, context, blocked, translate(query, 1));
}

void vcd_scene_occluded_sphere(const vcd_scene* scene, const vcd_sphere_bundle* bundle, const vcd_scene_query* query,
                               vcd_trace_unclassified trace, void* context, uint64_t* blocked) {
  occluded(scene->scene, translate(*bundle), trace, context, blocked, translate(query, 1));
}

void vcd_scene_occluded_point(const vcd_scene* scene, const vcd_point_bundle* bundle, const vcd_scene_query* query,
                              vcd_trace_unclassified trace, void* context, uint64_t* blocked) {
  occluded(scene->scene, translate(*bundle), trace, context, blocked, translate(query, 1));
}

}  // extern "C"
