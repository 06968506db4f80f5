#include "known_meshes.h"

#include <cstdio>
#include <map>
#include <mutex>

#include <vcd/runtime/sidecar_store.h>

#include "settings.h"

namespace vcd::preload {
namespace {

struct Known {
  std::mutex mutex;
  std::map<GeometryHash, std::optional<Object>> by_fingerprint;
  MeshCounts counts;
};
Known& known() {
  static Known& kept = *new Known;  // never destroyed: threads may still commit at exit
  return kept;
}

void say(const Error& error) { std::fprintf(stderr, "libvcd_embree3: %s\n", error.message.c_str()); }

// Null where there is none.
const SidecarStore* store() {
  static const SidecarStore* const kept = []() -> const SidecarStore* {
    if (settings().sidecars.empty()) return nullptr;
    OpenOptions options;
    options.proven_only = settings().answers != Answers::statistical;
    auto opened = SidecarStore::open(settings().sidecars, options);
    if (!opened) return say(opened.error()), nullptr;
    for (const Error& error : opened->passed_over()) say(error);
    return new SidecarStore(std::move(*opened));
  }();
  return kept;
}

// Renderers tell the processor to take subnormal numbers for zero. That is harmless in boxes of this extent
// (spec/vcd-format.md, "Line to cell"). Embree leaves out triangles beyond the other limit.
bool is_safe(const ObjectRecord& record) {
  constexpr float kLeastExtent = 0x1p-52f, kMost = 1e18f;
  for (int a = 0; a < 3; ++a)
    if (!(record.box_max[a] - record.box_min[a] >= kLeastExtent) || !(record.box_min[a] >= -kMost) ||
        !(record.box_max[a] <= kMost))
      return false;
  return true;
}

bool is_useful(Object object) {
  return is_safe(object.record()) &&
         (object.answers() || (settings().answers == Answers::exact && object.has_hierarchy()));
}

std::optional<Object> object_of(const GeometryHash& hash) {
  if (!store()) return std::nullopt;
  const auto found = store()->find(hash);
  if (!found) return say(found.error()), std::nullopt;
  return *found && is_useful(**found) ? *found : std::nullopt;
}

bool has_sidecar(const GeometryHash& hash) {
  if (!store()) return false;
  const auto found = store()->find(hash);
  return !found || *found;
}

// Reads the mesh.
std::optional<Object> look_up(const Mesh& mesh, bool& exported) {
  const auto hash = geometry_hash_of(mesh);
  if (!hash) return std::nullopt;  // Embree leaves out what is not sound; no sidecar can be of it
  if (!settings().export_to.empty() && !has_sidecar(*hash)) {
    const auto error = export_mesh(mesh, *hash, settings().export_to);
    if (error) say(*error);
    exported = !error;
  }
  return object_of(*hash);
}

}  // namespace

std::optional<Object> sidecar_of(const Mesh& mesh) {
  const GeometryHash fingerprint = fingerprint_of(mesh);
  Known& s = known();
  {
    const std::lock_guard lock(s.mutex);
    const auto found = s.by_fingerprint.find(fingerprint);
    if (found != s.by_fingerprint.end()) return found->second;
  }
  bool exported = false;
  const auto object = look_up(mesh, exported);  // unlocked: it takes long, and others commit meanwhile
  const std::lock_guard lock(s.mutex);
  if (s.by_fingerprint.emplace(fingerprint, object).second) {
    ++s.counts.meshes;
    s.counts.with_sidecar += object.has_value();
    s.counts.exported += exported;
  }
  return object;
}

MeshCounts mesh_counts() {
  const std::lock_guard lock(known().mutex);
  return known().counts;
}

}  // namespace vcd::preload
