#include "show_mesh.h"

#include <cstdio>

#include <vcd/baker/mesh_health.h>

#include "common/health_report.h"
#include "common/meshes.h"
#include "common/paths.h"
#include "common/program.h"

namespace vcd::tools {

using namespace baker;
namespace {

std::string text_of(const PreparedMesh& mesh, const MeshHealth& health) {
  char box[256];
  const auto& [low, high] = std::pair(mesh.box_min, mesh.box_max);
  const auto wide = [](float x) { return static_cast<double>(x); };
  std::snprintf(box, sizeof box, "  box       (%.9g, %.9g, %.9g) to (%.9g, %.9g, %.9g)\n", wide(low[0]), wide(low[1]),
                wide(low[2]), wide(high[0]), wide(high[1]), wide(high[2]));
  return "mesh " + std::to_string(mesh.source_index) + " " + printable(mesh.name) + "\n  mesh      " +
         std::to_string(mesh.triangles.size()) + " triangles, " + std::to_string(mesh.positions.size()) +
         " vertices, geometry hash " + hex(mesh.geometry_hash) + "\n" + box + health_summary(health);
}

Json json_of(const PreparedMesh& mesh, const MeshHealth& health) {
  return {{"name", mesh.name},
          {"source_index", mesh.source_index},
          {"triangle_count", mesh.triangles.size()},
          {"vertex_count", mesh.positions.size()},
          {"geometry_hash", hex(mesh.geometry_hash)},
          {"box_min", mesh.box_min},
          {"box_max", mesh.box_max},
          {"surface", describe_health(health)}};
}

}  // namespace

Result<ShownMesh> show_mesh(const std::string& path, const IngestOptions& options, bool quiet) {
  auto file = MeshFile::read(path, options);
  if (!file) return file.error();
  ShownMesh shown_mesh{shown(path) + ":\n",
                       {{"file", path}, {"meshes", Json::array()}},
                       std::string(kCulpritsBegin) + shown(path) + "\n"};
  uint64_t vertices = 0;
  while (const auto mesh = file->next()) {
    const MeshHealth health = mesh_health(mesh->positions.size(), mesh->triangles);
    shown_mesh.text += text_of(*mesh, health);
    shown_mesh.json["meshes"].push_back(json_of(*mesh, health));
    shown_mesh.culprits += culprits_as_obj(*mesh, health, vertices);
  }
  if (auto fault = file->fault()) return *std::move(fault);
  if (!quiet)
    for (const std::string& note : file->notes()) print_note(shown(path) + ": " + note);
  return shown_mesh;
}

}  // namespace vcd::tools
