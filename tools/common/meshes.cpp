#include "meshes.h"

#include <utility>

#include <vcd/baker/bake.h>
#include <vcd/baker/ingest.h>

namespace vcd {
using namespace baker;

void add_outside_files(CLI::App& app, IngestOptions& options) {
  app.add_flag("--allow-outside-files", options.files_outside,
               "Let a mesh file name files that are not in its folder or below it; for trusted files only");
}

std::optional<Error> each_mesh(const std::string& path, const IngestOptions& options, const TakeMesh& take) {
  auto ingested = ingest_isolated(path, options);
  if (!ingested) return ingested.error();
  for (SourceMesh& source : ingested->meshes) {
    const std::string name = source.name;
    const uint32_t index = source.source_index;
    take(name, index, prepare(std::move(source)));
  }
  return std::nullopt;
}

IngestOptions ingest_options_of(const SidecarContents& sidecar, IngestOptions options) {
  for (const auto& [key, value] : sidecar.provenance)
    if (key == "parts") options.treat_all_as_opaque = value != "opaque";
  return options;
}

Result<std::vector<PreparedMesh>> load_meshes(const std::string& path, const IngestOptions& options) {
  std::vector<PreparedMesh> meshes;
  Error last;
  const auto fault = each_mesh(path, options, [&](const std::string&, uint32_t, Result<PreparedMesh>&& mesh) {
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
