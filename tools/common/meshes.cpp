#include "meshes.h"

#include <utility>

#include <vcd/baker/bake.h>
#include <vcd/baker/ingest.h>

namespace vcd {
using namespace baker;

std::optional<Error> each_mesh(const std::string& path, bool all_as_opaque, const TakeMesh& take) {
  auto ingested = ingest_isolated(path, {.treat_all_as_opaque = all_as_opaque});
  if (!ingested) return ingested.error();
  for (SourceMesh& source : ingested->meshes) {
    const std::string name = source.name;
    const uint32_t index = source.source_index;
    take(name, index, prepare(std::move(source)));
  }
  return std::nullopt;
}

bool baked_all_as_opaque(const SidecarContents& sidecar) {
  for (const auto& [key, value] : sidecar.provenance)
    if (key == "parts") return value != "opaque";
  return false;
}

Result<std::vector<PreparedMesh>> load_meshes(const std::string& path, const SidecarContents* sidecar) {
  std::vector<PreparedMesh> meshes;
  Error last;
  const auto fault = each_mesh(path, sidecar && baked_all_as_opaque(*sidecar),
                               [&](const std::string&, uint32_t, Result<PreparedMesh>&& mesh) {
                                 if (mesh) return meshes.push_back(std::move(*mesh));
                                 last = Error{mesh.error().code, path + ": " + mesh.error().message};
                               });
  if (fault) return *fault;
  if (meshes.empty()) return last;
  return meshes;
}

Result<PreparedMesh> embedded_mesh(const std::string& path, const ObjectContents& object) {
  auto source = decode_geometry_isolated(object.geometry, path + ": embedded geometry");
  if (!source) return source.error();
  auto mesh = prepare(std::move(*source));
  if (!mesh) return Error{ErrorCode::invalid_file, path + ": embedded geometry: " + mesh.error().message};
  return mesh;
}

}  // namespace vcd
