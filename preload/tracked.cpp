#include "tracked.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <type_traits>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "known_meshes.h"
#include "next.h"
#include "settings.h"
#include "view.h"

namespace vcd::preload {
namespace {

struct TrackedGeometry {
  RTCDevice device;
  Geometry told;
  unsigned references = 1;
  std::vector<RTCScene> scenes = {};                // that it is attached to, once for each time
  std::optional<std::optional<Object>> known = {};  // since its last change
  unsigned misses = 0;                              // how often it changed into what has no sidecar
};

struct TrackedScene {
  RTCDevice device;
  bool masks_matter, culls;  // as Embree was built
  unsigned references = 1;   // instances count too
  std::map<unsigned, RTCGeometry> attached = {};
  std::unordered_set<RTCGeometry> instances = {};
  bool odd = false;           // what is attached is not known for certain
  bool is_committed = false;  // and unchanged since
  bool is_read = false;       // by a thread that makes the view
  uint64_t changes = 0;
  std::unique_ptr<const View> view = {};  // published while is_committed
};

struct State {
  std::mutex mutex;
  std::unordered_map<RTCGeometry, TrackedGeometry> geometries;
  std::unordered_map<RTCScene, TrackedScene> scenes;

  TrackedGeometry* find(RTCGeometry geometry) {
    const auto found = geometries.find(geometry);
    return found == geometries.end() ? nullptr : &found->second;
  }
  TrackedScene* find(RTCScene scene) {
    const auto found = scenes.find(scene);
    return found == scenes.end() ? nullptr : &found->second;
  }

  void changed(RTCScene handle) {
    TrackedScene* scene = find(handle);
    if (!scene) return;
    ++scene->changes;
    if (!std::exchange(scene->is_committed, false)) return;  // no view has it
    publish(handle, nullptr);
    for (const RTCGeometry instance : scene->instances)
      for (const RTCScene outer : geometries.at(instance).scenes) changed(outer);
  }

  void dereference(RTCScene handle) {
    TrackedScene* scene = find(handle);
    if (scene && --scene->references == 0) forget(handle);
  }
  void dereference(RTCGeometry handle) {
    TrackedGeometry* geometry = find(handle);
    if (geometry && --geometry->references == 0) forget(handle);
  }
  // It ends; or another one has its address now, since its end was missed.
  void forget(RTCScene handle) {
    TrackedScene* scene = find(handle);
    if (!scene) return;
    changed(handle);
    for (const RTCGeometry instance : scene->instances) geometries.at(instance).told.instanced = nullptr;
    const auto attached = std::move(scene->attached);
    scenes.erase(handle);
    for (const auto& [id, geometry] : attached) leave(handle, geometry);
  }
  void forget(RTCGeometry handle) {
    TrackedGeometry* geometry = find(handle);
    if (!geometry) return;
    for (const RTCScene scene : geometry->scenes) {
      changed(scene);
      if (TrackedScene* tracked = find(scene)) tracked->odd = true;
    }
    uninstance(handle);
    geometries.erase(handle);
  }
  void leave(RTCScene scene, RTCGeometry handle) {
    TrackedGeometry* geometry = find(handle);
    if (!geometry) return;
    const auto place = std::find(geometry->scenes.begin(), geometry->scenes.end(), scene);
    if (place != geometry->scenes.end()) geometry->scenes.erase(place);
    dereference(handle);
  }
  void uninstance(RTCGeometry handle) {
    const RTCScene inner = std::exchange(geometries.at(handle).told.instanced, nullptr);
    if (TrackedScene* scene = find(inner)) {
      scene->instances.erase(handle);
      dereference(inner);
    }
  }
};

State& state() {
  alignas(State) static std::byte memory[sizeof(State)];
  static State& kept = *new (memory) State;  // never destroyed: threads may still be rendering at exit
  return kept;
}

// False: it returned false, or threw. Embree's callers may be written in C: nothing is thrown at them.
template <class Do>
bool without_throwing(const Do& action) noexcept try {
  if constexpr (std::is_void_v<decltype(action())>) return action(), true;
  else return action();
} catch (const std::exception& error) {
  return std::fprintf(stderr, "libvcd_embree3: %s\n", error.what()), false;
}

bool is_mesh(const Geometry& geometry) {
  return (geometry.type == RTC_GEOMETRY_TYPE_TRIANGLE || geometry.type == RTC_GEOMETRY_TYPE_QUAD) &&
         geometry.time_steps == 1 && !geometry.odd && is_plain(geometry.mesh);
}

// A mesh that keeps changing and never has a sidecar is animated: it is no longer read.
constexpr unsigned kMostMisses = 4;

using Read = std::pair<RTCGeometry, Mesh>;

// What must be read before the scene's view can be made. Nothing: there is no need for another view.
std::optional<std::vector<Read>> begin_view(RTCScene handle, bool failed, uint64_t& changes) {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  TrackedScene* scene = s.find(handle);
  if (!scene || scene->is_committed || scene->is_read) return std::nullopt;
  if (failed) ++scene->changes;
  if (failed || scene->odd) return std::nullopt;
  changes = scene->changes;
  std::vector<Read> reads;
  for (const auto& [id, handle_of] : scene->attached) {
    const TrackedGeometry* geometry = s.find(handle_of);
    if (geometry && geometry->told.enabled && is_mesh(geometry->told) && !geometry->known &&
        geometry->misses < kMostMisses)
      reads.emplace_back(handle_of, geometry->told.mesh);
  }
  scene->is_read = true;
  return reads;
}

struct ReadsEnd {
  RTCScene handle;
  ~ReadsEnd() {
    const std::lock_guard lock(state().mutex);
    if (TrackedScene* scene = state().find(handle)) scene->is_read = false;
  }
};

bool has_sidecar(const TrackedGeometry* geometry) {
  return geometry && is_mesh(geometry->told) && geometry->known && *geometry->known;
}

void add_mesh(ViewMaker& view, const TrackedGeometry& geometry, const Transform& to_world) {
  view.add(**geometry.known, to_world);
  view.add_mask(geometry.told.mask);
  if (geometry.told.filtered) view.add_filter();
}

// The scene that an instance is of, if all that it holds has sidecars.
const TrackedScene* sidecars_of(const Geometry& instance) {
  const TrackedScene* inner = state().find(instance.instanced);
  if (!inner || !inner->is_committed || instance.time_steps != 1 || instance.odd) return nullptr;
  for (const auto& [id, handle] : inner->attached) {
    const TrackedGeometry* geometry = state().find(handle);
    if (!has_sidecar(geometry) && (!geometry || geometry->told.enabled)) return nullptr;
  }
  return inner;
}

void add_instance(ViewMaker& view, RTCGeometry handle, const Geometry& instance, const TrackedScene& inner) {
  Transform to_world;
  VCD_NEXT(rtcGetGeometryTransform)(handle, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, &to_world);
  view.add_mask(instance.mask);
  for (const auto& [id, geometry] : inner.attached)
    if (state().geometries.at(geometry).told.enabled) add_mesh(view, state().geometries.at(geometry), to_world);
}

// Under the lock.
ViewMaker parts_of(const TrackedScene& scene) {
  ViewMaker view(scene.masks_matter);
  if (scene.culls) view.add_filter();
  for (const auto& [id, handle] : scene.attached) {
    const TrackedGeometry* geometry = state().find(handle);
    if (geometry && !geometry->told.enabled) continue;
    const bool is_instance = geometry && geometry->told.type == RTC_GEOMETRY_TYPE_INSTANCE;
    const TrackedScene* inner = is_instance ? sidecars_of(geometry->told) : nullptr;
    if (inner) add_instance(view, handle, geometry->told, *inner);
    else if (has_sidecar(geometry)) add_mesh(view, *geometry, kIdentity);
    else view.add_rest(handle, id);
  }
  return view;
}

void make_view(RTCScene handle, uint64_t changes, const std::vector<Read>& reads) {
  std::vector<std::optional<Object>> known;
  known.reserve(reads.size());
  for (const auto& [geometry, mesh] : reads) known.push_back(sidecar_of(mesh));  // takes long: without the lock

  State& s = state();
  std::unique_lock lock(s.mutex);
  TrackedScene* scene = s.find(handle);
  if (!scene || scene->changes != changes) return;
  for (size_t i = 0; i < reads.size(); ++i) {
    TrackedGeometry& geometry = s.geometries.at(reads[i].first);
    geometry.known = known[i];
    geometry.misses = known[i] ? 0 : geometry.misses + 1;
  }
  const RTCDevice device = scene->device;
  const ViewMaker parts = parts_of(*scene);
  lock.unlock();
  std::unique_ptr<const View> view = parts.make(device, handle);  // takes long
  lock.lock();
  scene = s.find(handle);
  if (!scene || scene->changes != changes) return;
  scene->is_committed = true;
  publish(handle, nullptr);
  scene->view = std::move(view);
  if (!publish(handle, scene->view.get())) std::fprintf(stderr, "libvcd_embree3: too many scenes\n");
}

}  // namespace

void add_scene(RTCScene scene, RTCDevice device) noexcept {
  const auto property = VCD_NEXT(rtcGetDeviceProperty);
  TrackedScene fresh{device, property(device, RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) != 0,
                     property(device, RTC_DEVICE_PROPERTY_BACKFACE_CULLING_ENABLED) != 0};
  State& s = state();
  const std::lock_guard lock(s.mutex);
  s.forget(scene);
  without_throwing([&] { s.scenes.emplace(scene, std::move(fresh)); });
}

void add_geometry(RTCGeometry geometry, RTCDevice device, RTCGeometryType type) noexcept {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  s.forget(geometry);
  TrackedGeometry fresh{device, Geometry{type}};
  if (type == RTC_GEOMETRY_TYPE_QUAD) fresh.told.mesh.corners = 4;
  without_throwing([&] { s.geometries.emplace(geometry, std::move(fresh)); });
}

void retain(RTCScene scene) noexcept {
  const std::lock_guard lock(state().mutex);
  if (TrackedScene* tracked = state().find(scene)) ++tracked->references;
}
void retain(RTCGeometry geometry) noexcept {
  const std::lock_guard lock(state().mutex);
  if (TrackedGeometry* tracked = state().find(geometry)) ++tracked->references;
}
void release(RTCScene scene) noexcept {
  const std::lock_guard lock(state().mutex);
  state().dereference(scene);
}
void release(RTCGeometry geometry) noexcept {
  const std::lock_guard lock(state().mutex);
  state().dereference(geometry);
}

void attach(RTCScene handle, RTCGeometry geometry, unsigned id) noexcept {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  TrackedScene* scene = s.find(handle);
  TrackedGeometry* tracked = s.find(geometry);
  if (!scene) return;
  s.changed(handle);
  // Embree refuses the second geometry of an id, the call failed, or memory is short: what the scene holds is not known
  // for certain.
  const bool known = without_throwing([&] {
    if (!tracked || id == RTC_INVALID_GEOMETRY_ID || !scene->attached.emplace(id, geometry).second) return false;
    ++tracked->references;
    tracked->scenes.push_back(handle);
    return true;
  });
  if (!known) scene->odd = true;
}

void detach(RTCScene handle, unsigned id) noexcept {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  TrackedScene* scene = s.find(handle);
  if (!scene) return;
  s.changed(handle);
  const auto found = scene->attached.find(id);
  if (found == scene->attached.end()) return;
  const RTCGeometry geometry = found->second;
  scene->attached.erase(found);
  s.leave(handle, geometry);
}

void set_instanced(RTCGeometry geometry, RTCScene inner) noexcept {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  TrackedGeometry* tracked = s.find(geometry);
  if (!tracked) return;
  for (const RTCScene outer : tracked->scenes) s.changed(outer);
  TrackedScene* scene = s.find(inner);
  if (scene) ++scene->references;  // before it lets go of the old one, which may be the same
  s.uninstance(geometry);
  if (!scene) return;
  tracked->told.instanced = inner;
  const bool known = without_throwing([&] { scene->instances.insert(geometry); });
  if (!known) tracked->told.odd = true;  // it would not hear of changes
}

void change(RTCGeometry geometry, const std::function<void(Geometry&)>& change) noexcept {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  TrackedGeometry* tracked = s.find(geometry);
  if (!tracked) return;
  change(tracked->told);
  tracked->known.reset();
  for (const RTCScene scene : tracked->scenes) s.changed(scene);
}

RTCDevice device_of(RTCScene scene) noexcept {
  const std::lock_guard lock(state().mutex);
  const TrackedScene* tracked = state().find(scene);
  return tracked ? tracked->device : nullptr;
}

RTCDevice device_of(RTCGeometry geometry) noexcept {
  const std::lock_guard lock(state().mutex);
  const TrackedGeometry* tracked = state().find(geometry);
  return tracked ? tracked->device : nullptr;
}

void committed(RTCScene scene, bool failed) noexcept {
  without_throwing([&] {
    if (!settings().reads_meshes()) return;
    uint64_t changes = 0;
    const auto reads = begin_view(scene, failed, changes);
    if (!reads) return;
    const ReadsEnd at_end{scene};
    make_view(scene, changes, *reads);
  });
}

}  // namespace vcd::preload
