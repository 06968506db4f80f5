#include "scene_source.h"

#include <filesystem>

#include <vcd/baker/ingest.h>

#include "common/program.h"

namespace vcd {
namespace {

// One mesh stands as around() puts it; several stand together as around() would put the box of them all.
Result<scenes::Scene> from_files(const std::vector<std::string>& paths, const SceneOptions& options, bool quiet,
                                 std::vector<std::string>& sources) {
  std::vector<scenes::Mesh> meshes;
  for (const std::string& path : paths) {
    auto ingested = ingest_isolated(path);
    if (!ingested) return ingested.error();
    for (const std::string& note : ingested->notes)
      if (!quiet) print_note(path + ": " + note);
    for (SourceMesh& mesh : ingested->meshes) {
      meshes.push_back({std::move(mesh.name), std::move(mesh.positions), std::move(mesh.triangles), {0.7f, 0.7f, 0.7f}});
      sources.push_back(path);
    }
  }
  if (meshes.size() == 1) {
    scenes::Scene scene = scenes::around(std::move(meshes[0]), options.up, options.turn_degrees);
    scene.name = std::filesystem::path(paths[0]).stem().string();
    return scene;
  }
  Box box;
  for (const scenes::Mesh& mesh : meshes)
    for (const auto& triangle : mesh.triangles)
      for (uint32_t corner : triangle) box.add(vec3(mesh.positions[corner]));
  scenes::Mesh bounds{"bounds", {{box.low.x, box.low.y, box.low.z}, {box.high.x, box.high.y, box.high.z},
                                 {box.low.x, box.high.y, box.low.z}}, {{0, 1, 2}}, {}};
  scenes::Scene scene = scenes::around(std::move(bounds), options.up, options.turn_degrees);
  const scenes::Transform transform = scene.instances[0].transform;
  scene.name = std::filesystem::path(paths[0]).stem().string();
  scene.meshes = std::move(meshes);
  scene.instances.clear();
  for (uint32_t i = 0; i < scene.meshes.size(); ++i) scene.instances.push_back({i, transform});
  return scene;
}

}  // namespace

void add_scene_options(CLI::App& app, SceneOptions& options) {
  add_generated_scene_options(app, options.generated, "--scene-seed");
  app.add_option("--up", options.up, "The axis that points up, x, y or z (default: y)")
      ->check(CLI::IsMember({'x', 'y', 'z'}))
      ->group("Mesh files");
  app.add_option("--turn", options.turn_degrees, "Degrees to turn the object on the spot (default: 0)")->group("Mesh files");
}

Result<World> load_world(const std::vector<std::string>& names, const SceneOptions& options, bool quiet) {
  const bool generated = is_generated_scene(names[0]);
  if (generated && names.size() > 1)
    return Error{ErrorCode::usage, names[1] + ": a generated scene is drawn alone"};
  std::vector<std::string> sources;
  auto scene = generated ? generate_scene(names[0], options.generated) : from_files(names, options, quiet, sources);
  if (!scene) return scene.error();
  sources.resize(scene->meshes.size(), names[0]);
  return build_world(std::move(*scene), sources);
}

}  // namespace vcd
