#include "meshes.h"

#include <utility>

#include <vcd/baker/bake.h>
#include <vcd/baker/ingest.h>

namespace vcd {

Result<std::vector<PreparedMesh>> load_meshes(const std::string& path, const SidecarContents* sidecar) {
  IngestOptions options;
  if (sidecar)
    for (const auto& [key, value] : sidecar->provenance)
      if (key == "parts") options.treat_all_as_opaque = value != "opaque";
  auto ingested = ingest_isolated(path, options);
  if (!ingested) return ingested.error();
  std::vector<PreparedMesh> meshes;
  Error last;
  for (SourceMesh& source : ingested->meshes) {
    auto mesh = prepare(std::move(source));
    if (mesh) {
      meshes.push_back(std::move(*mesh));
    } else {
      last = Error{mesh.error().code, path + ": " + mesh.error().message};
    }
  }
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
