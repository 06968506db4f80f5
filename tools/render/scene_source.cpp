#include "scene_source.h"

#include <filesystem>

#include <vcd/baker/ingest.h>

#include "common/memory.h"
#include "common/program.h"

namespace vcd {
namespace {

// Source triangles and positions of a generated mesh, before anything else is made of it.
constexpr uint64_t kGeneratedBytesPerTriangle = 100;

Result<scenes::Scene> generate(const std::string& name, const SceneOptions& options) {
  const uint64_t triangles = name == "sierpinski" ? uint64_t{4} << 2 * options.level
                             : name == "hairball" ? scenes::hairball_triangles(options.hairball)
                                                  : scenes::forest_mesh_triangles_bound(options.forest);
  if (auto error = check_memory(name, triangles * kGeneratedBytesPerTriangle)) return *error;
  if (name == "sierpinski") return scenes::sierpinski(options.level);
  return name == "hairball" ? scenes::hairball(options.hairball) : scenes::forest(options.forest);
}

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
  const auto add = [&](const char* name, auto& value, const char* what, uint64_t low, uint64_t high) {
    app.add_option(name, value, what)->check(CLI::Range(low, high))->group("Scene");
  };
  add("--level", options.level, "sierpinski: levels; 4^(level + 1) triangles (default: 8)", 0, 12);
  add("--strands", options.hairball.strands, "hairball: hairs (default: 10000)", 1, 100000000);
  add("--segments", options.hairball.segments, "hairball: segments of a hair (default: 24)", 1, 10000);
  add("--sides", options.hairball.sides, "hairball: sides of a hair (default: 6)", 3, 64);
  add("--instances", options.forest.instances, "forest: trees (default: 200)", 1, 1000000);
  add("--species", options.forest.species, "forest: kinds of trees (default: 3)", 1, 4);
  add("--leaves", options.forest.leaves, "forest: leaves of one tree, about (default: 8000)", 10, 10000000);
  app.add_option("--up", options.up, "Mesh files: the axis that points up, x, y or z (default: y)")
      ->check(CLI::IsMember({'x', 'y', 'z'}))
      ->group("Scene");
  app.add_option("--turn", options.turn_degrees, "Mesh files: degrees to turn the object on the spot (default: 0)")->group("Scene");
}

bool is_generated_scene(const std::string& name) {
  return name == "sierpinski" || name == "hairball" || name == "forest";
}

Result<World> load_world(const std::vector<std::string>& names, const SceneOptions& options, bool quiet) {
  const bool generated = is_generated_scene(names[0]);
  if (generated && names.size() > 1)
    return Error{ErrorCode::usage, names[1] + ": a generated scene is drawn alone"};
  std::vector<std::string> sources;
  auto scene = generated ? generate(names[0], options) : from_files(names, options, quiet, sources);
  if (!scene) return scene.error();
  sources.resize(scene->meshes.size(), names[0]);
  return build_world(std::move(*scene), sources);
}

}  // namespace vcd
