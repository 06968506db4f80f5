// vc-scene: writes a generated scene, or a mesh as all programs here read it, as GLB: for vc-bake and for any other
// program that reads glTF.
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include <vcd/baker/ingest.h>
#include <vcd/library/find.h>
#include <vcd/scenes/glb.h>
#include <vcd/writer/atomic_file.h>

#include "bake/options.h"
#include "common/describe.h"
#include "common/paths.h"
#include "common/program.h"
#include "render/generated_scene.h"

namespace {

using namespace vcd;
using namespace vcd::render;
using namespace vcd::tools;

struct Options {
  CommonOptions common;
  std::string output;
  std::string name;
  GeneratedSceneOptions scene;
  library::BakeSettings settings;  // of which those count that say how a mesh is read
  char up = 'y';
};

// The mesh with its triangles as they were wound, in the paper's setting. Errors: those of ingest_isolated(); usage.
Result<scenes::Scene> read_scene(const Options& options) {
  auto ingested = baker::ingest_isolated(options.name, options.settings.ingest_options());
  if (!ingested) return ingested.error();
  if (ingested->meshes.size() != 1)
    return Error{ErrorCode::usage, options.name + ": holds " + std::to_string(ingested->meshes.size()) +
                                       " meshes, and vc-scene takes files of one"};
  if (!options.common.quiet)
    for (const std::string& note : ingested->notes) print_note(options.name + ": " + note);
  baker::SourceMesh& mesh = ingested->meshes[0];
  return scenes::around(
      {shown(std::filesystem::path(options.name).stem()), std::move(mesh.positions), std::move(mesh.triangles)},
      options.up);
}

// Errors: those of AtomicFile; runtime (interrupted).
Result<uint64_t> write(const std::string& path, Bytes bytes) {
  AtomicFile file(path);
  file.append(bytes);
  if (interrupted()) return Error{ErrorCode::runtime, "interrupted"};
  return file.commit();
}

void report(const Options& options, const scenes::Scene& scene, uint64_t bytes) {
  uint64_t triangles = 0;
  for (const scenes::Mesh& mesh : scene.meshes) triangles += mesh.triangles.size();
  if (options.common.format == OutputFormat::json) {
    Json meshes = Json::array();
    for (const scenes::Mesh& mesh : scene.meshes)
      meshes.push_back({{"name", mesh.name}, {"triangle_count", mesh.triangles.size()}});
    print_json({{"tool", "vc-scene"},
                {"version", VCD_VERSION},
                {"scene", scene.name},
                {"file", options.output},
                {"bytes", bytes},
                {"triangle_count", triangles},
                {"instance_count", scene.instances.size()},
                {"meshes", meshes}});
  } else if (!options.common.quiet) {
    const auto plural = [](size_t count) { return count == 1 ? "" : "s"; };
    std::printf("%s -> %s: %llu triangles in %zu mesh%s, %zu instance%s, %llu bytes\n", scene.name.c_str(),
                options.output.c_str(), static_cast<unsigned long long>(triangles), scene.meshes.size(),
                scene.meshes.size() == 1 ? "" : "es", scene.instances.size(), plural(scene.instances.size()),
                static_cast<unsigned long long>(bytes));
  }
}

Result<std::vector<std::byte>> glb_of(const scenes::Scene& scene) {
  try {
    return scenes::to_glb(scene);
  } catch (const std::length_error& e) {
    return Error{ErrorCode::unsupported, e.what()};
  }
}

std::string fault_of_scene(const std::string& name) {
  if (is_generated_scene(name) || library::has_extension(name, baker::mesh_extensions())) return "";
  return name + " is neither sierpinski, hairball or forest nor a mesh file";
}

std::string fault_of_name(const std::string& path) {
  return extension_of(path) == "glb" ? "" : "what is written is GLB: its name must end in .glb";
}

int run(const Options& options) {
  catch_interruptions();
  const auto fail = [](const Error& error) {
    print_error(error.message);
    return exit_code(error.code);
  };
  const auto scene =
      is_generated_scene(options.name) ? generate_scene(options.name, options.scene) : read_scene(options);
  if (!scene) return fail(scene.error());
  const auto glb = glb_of(*scene);
  if (!glb) return fail(glb.error());
  const auto written = write(options.output, *glb);
  if (!written) return fail(written.error());
  report(options, *scene, *written);
  return kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Generates a scene, or puts a mesh under lights and before a camera, and writes it as GLB. The same options give "
      "the same\nbytes on every machine."};
  app.add_option("scene", options.name, "The scene to generate, or a file of one mesh")
      ->required()
      ->check(fault_of_scene, "")
      ->type_name("sierpinski|hairball|forest|MESH");
  app.add_option("-o,--output", options.output, "The file to write, named .glb")
      ->required()
      ->check(fault_of_name, "")
      ->type_name("PATH");
  add_common_options(app, options.common);
  add_reading_settings(app, options.settings);
  app.add_option("--up", options.up, "The axis of the mesh that points up (default: y)")
      ->check(CLI::IsMember({'x', 'y', 'z'}).description(""))
      ->type_name("x|y|z");
  add_generated_scene_options(app, options.scene, "--seed");
  return run_program(app, argc, argv, [&] { return run(options); });
}
