#include <vcd/library/object_cache.h>

#include <algorithm>

#include <vcd/baker/horizon.h>
#include <vcd/library/provenance.h>
#include "common/describe.h"

namespace vcd::library {

using namespace baker;
namespace {

using namespace tools;

namespace fs = std::filesystem;

// What decides about an object's bytes beside its geometry; in entries as provenance.
std::map<std::string, std::string> object_provenance(const BakeSettings& settings) {
  return {{"baker", baker_text()}, {"settings", settings_text(settings, Scope::object)}};
}

std::string entry_name(const PreparedMesh& mesh, const BakeSettings& settings) {
  std::string key = hex(mesh.geometry_hash);
  for (const auto& [name, value] : object_provenance(settings)) key += "\n" + name + "=" + value;
  if (settings.horizons) key += "\n" + std::to_string(order_of(mesh));
  return hex(content_hash(key));
}

// Horizons are of one order of the source's triangles.
bool is_of_order(const HorizonView& horizon, const PreparedMesh& mesh) {
  return !horizon ||
         (horizon.header().order_xxh3 == order_of(mesh) && horizon.header().entries == mesh.source_triangles.size());
}

// The sidecar's object of that geometry, if its provenance has these pairs.
std::optional<CachedObject> find_object(const fs::path& path, const std::map<std::string, std::string>& pairs,
                                        const PreparedMesh& mesh) {
  auto file = FileBytes::copy(path);
  if (!file) return std::nullopt;
  const auto bytes = std::make_shared<const FileBytes>(std::move(*file));
  std::vector<Finding> findings;
  auto read = read_sidecar(bytes->bytes(), CheckLevel::canonical, findings);
  if (!read) return std::nullopt;
  for (const auto& [key, value] : pairs)
    if (provenance_value(*read, key) != value) return std::nullopt;
  const auto contents = std::make_shared<const SidecarContents>(std::move(*read));
  for (size_t i = 0; i < contents->objects.size(); ++i) {
    const ObjectRecord& record = *contents->objects[i].record;
    const bool same = record.geometry_hash == mesh.geometry_hash && record.triangle_count == mesh.triangles.size() &&
                      std::equal(mesh.box_min.begin(), mesh.box_min.end(), record.box_min) &&
                      std::equal(mesh.box_max.begin(), mesh.box_max.end(), record.box_max) &&
                      is_of_order(contents->objects[i].horizon, mesh);
    if (same) return CachedObject(bytes, contents, i, mesh);
  }
  return std::nullopt;
}

}  // namespace

CachedObject::CachedObject(std::shared_ptr<const FileBytes> file, std::shared_ptr<const SidecarContents> contents,
                           size_t index, const PreparedMesh& mesh)
    : file_(std::move(file)),
      contents_(std::move(contents)),
      index_(index),
      name_(mesh.name),
      record_(*this->contents().record) {
  describe_source(mesh, record_);
}

ObjectToWrite CachedObject::to_write() const {
  return {name_,
          record_,
          tree_pieces(contents().tree),
          contents().geometry,
          contents().hierarchy.bytes(),
          contents().clearance,
          contents().horizon.all_bytes()};
}

std::optional<CachedObject> ObjectCache::find(const PreparedMesh& mesh, const BakeSettings& settings) const {
  if (folder_.empty()) return std::nullopt;
  const std::string name = entry_name(mesh, settings);
  return find_object(folder_ / name.substr(0, 2) / (name + ".vcd"), object_provenance(settings), mesh);
}

std::optional<Error> ObjectCache::keep(const PreparedMesh& mesh, const BakeSettings& settings,
                                       const ObjectToWrite& object) const {
  if (folder_.empty()) return std::nullopt;
  const std::string name = entry_name(mesh, settings);
  const fs::path folder = folder_ / name.substr(0, 2);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return Error{ErrorCode::io, folder.string() + ": " + error.message()};
  SidecarToWrite entry;
  entry.objects = {object};
  entry.objects[0].name = {};
  describe_source({}, entry.objects[0].record);
  entry.provenance = object_provenance(settings);
  const auto written = write_sidecar(folder / (name + ".vcd"), entry);
  return written ? std::nullopt : std::optional(written.error());
}

std::optional<CachedObject> find_in_sidecar(const fs::path& sidecar, const PreparedMesh& mesh,
                                            const BakeSettings& settings) {
  return find_object(sidecar, {{"baker", baker_text()}, {"settings", settings_text(settings, Scope::asset)}}, mesh);
}

std::optional<CachedObject> find_older_in_sidecar(const fs::path& sidecar, const PreparedMesh& mesh) {
  return find_object(sidecar, {{"baker", baker_text()}}, mesh);
}

}  // namespace vcd::library
