#include "scene_source.h"

#include <cmath>
#include <filesystem>

#include <vcd/baker/ingest.h>

#include "common/program.h"

namespace vcd::render {

using namespace tools;
namespace {

struct Parts {
  std::vector<scenes::Mesh> meshes;
  std::vector<Placement> placements;  // of the meshes; each stands somewhere
};

// Several files stand together mesh by mesh, as they are; one file as its nodes say.
Result<Parts> read_parts(const std::vector<std::string>& paths, bool quiet, std::vector<std::string>& sources) {
  Parts parts;
  for (const std::string& path : paths) {
    auto ingested = ingest_isolated(path, {.placements = paths.size() == 1});
    if (!ingested) return ingested.error();
    for (const std::string& note : ingested->notes)
      if (!quiet) print_note(path + ": " + note);
    for (SourceMesh& mesh : ingested->meshes) {
      parts.meshes.push_back(
          {std::move(mesh.name), std::move(mesh.positions), std::move(mesh.triangles), {0.7f, 0.7f, 0.7f}});
      sources.push_back(path);
    }
    parts.placements = std::move(ingested->placements);
  }
  if (parts.placements.empty())
    for (uint32_t i = 0; i < parts.meshes.size(); ++i) parts.placements.push_back({.mesh = i});
  return parts;
}

// Meshes that stand nowhere are not drawn: they need neither hierarchy nor sidecar. Mesh i and sources[i] stay
// together.
void drop_unplaced(Parts& parts, std::vector<std::string>& sources) {
  std::vector<uint32_t> new_index(parts.meshes.size());
  for (const Placement& placement : parts.placements) new_index[placement.mesh] = 1;
  uint32_t kept = 0;
  for (uint32_t i = 0; i < new_index.size(); ++i) {
    if (new_index[i] == 0) continue;
    if (kept != i) parts.meshes[kept] = std::move(parts.meshes[i]), sources[kept] = std::move(sources[i]);
    new_index[i] = kept++;
  }
  parts.meshes.resize(kept), sources.resize(kept);
  for (Placement& placement : parts.placements) placement.mesh = new_index[placement.mesh];
}

// Moves, turns and scales all lengths alike, to what pictures show.
bool keeps_shape(const scenes::Transform& transform) {
  const Affine a = affine(transform);
  const Vec3 &x = a.column[0], &y = a.column[1], &z = a.column[2];
  const float size2 = dot(x, x), tolerance = 1e-4f * size2;
  return dot(cross(x, y), z) > 0 && std::fabs(dot(y, y) - size2) < tolerance &&
         std::fabs(dot(z, z) - size2) < tolerance && std::fabs(dot(x, y)) < tolerance &&
         std::fabs(dot(y, z)) < tolerance && std::fabs(dot(z, x)) < tolerance;
}

scenes::Transform after(const scenes::Transform& outer, const scenes::Transform& inner) {
  scenes::Transform product;
  for (size_t row = 0; row < 12; row += 4) {
    for (size_t column = 0; column < 4; ++column) {
      double sum = column == 3 ? outer[row + 3] : 0;
      for (size_t k = 0; k < 3; ++k) sum += double{outer[row + k]} * inner[4 * k + column];
      product[row + column] = static_cast<float>(sum);
    }
  }
  return product;
}

// The corners of the box about all that stands somewhere, all eight, so that they frame it however it is turned.
scenes::Mesh bounds_of(const Parts& parts) {
  Box box;
  for (const Placement& placement : parts.placements) {
    const scenes::Mesh& mesh = parts.meshes[placement.mesh];
    const Affine to_scene = affine(placement.transform);
    for (const auto& triangle : mesh.triangles)
      for (uint32_t corner : triangle) box.add(to_scene.point(vec3(mesh.positions[corner])));
  }
  scenes::Mesh mesh{"bounds", {}, {{0, 1, 2}}, {}};
  for (const float x : {box.low.x, box.high.x})
    for (const float y : {box.low.y, box.high.y})
      for (const float z : {box.low.z, box.high.z}) mesh.positions.push_back({x, y, z});
  return mesh;
}

// One mesh stands as around() puts it; whatever else there is stands together as around() would put the box of it all.
Result<scenes::Scene> from_files(const std::vector<std::string>& paths, const SceneOptions& options, bool quiet,
                                 std::vector<std::string>& sources) {
  auto parts = read_parts(paths, quiet, sources);
  if (!parts) return parts.error();
  drop_unplaced(*parts, sources);
  // One object in one place is drawn in its own frame, in which lights and camera must keep their shape.
  if (parts->placements.size() == 1 && !keeps_shape(parts->placements[0].transform)) {
    if (!quiet)
      print_note(paths[0] + ": drawn without what its node does to its only mesh, which is to stretch or mirror it");
    parts->placements[0] = {};
  }
  scenes::Scene scene;
  if (parts->placements == std::vector<Placement>(1)) {
    scene = scenes::around(std::move(parts->meshes[0]), options.up, options.turn_degrees);
  } else {
    scene = scenes::around(bounds_of(*parts), options.up, options.turn_degrees);
    const scenes::Transform turn = scene.instances[0].transform;
    scene.meshes = std::move(parts->meshes);
    scene.instances.clear();
    for (const Placement& placement : parts->placements)
      scene.instances.push_back({placement.mesh, after(turn, placement.transform)});
  }
  scene.name = std::filesystem::path(paths[0]).stem().string();
  return scene;
}

}  // namespace

void add_scene_options(CLI::App& app, SceneOptions& options) {
  add_generated_scene_options(app, options.generated, "--scene-seed");
  app.add_option("--up", options.up, "The axis that points up (default: y)")
      ->check(CLI::IsMember({'x', 'y', 'z'}).description(""))
      ->type_name("x|y|z")
      ->group("Mesh files");
  app.add_option("--turn", options.turn_degrees, "Degrees to turn the object on the spot (default: 0)")
      ->check(NumberRange(-3600.0, 3600.0))
      ->group("Mesh files");
}

Result<World> load_world(const std::vector<std::string>& names, const SceneOptions& options, bool quiet) {
  const bool generated = is_generated_scene(names[0]);
  if (generated && names.size() > 1) return Error{ErrorCode::usage, names[1] + ": a generated scene is drawn alone"};
  std::vector<std::string> sources;
  auto scene = generated ? generate_scene(names[0], options.generated) : from_files(names, options, quiet, sources);
  if (!scene) return scene.error();
  sources.resize(scene->meshes.size(), names[0]);
  return build_world(std::move(*scene), sources);
}

}  // namespace vcd::render
