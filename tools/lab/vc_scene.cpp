// vc-scene: writes a generated scene as GLB, for vc-bake and for any other program that reads glTF.
#include <cstdio>
#include <stdexcept>

#include <vcd/scenes/glb.h>
#include <vcd/writer/atomic_file.h>

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
};

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

std::string fault_of_name(const std::string& path) {
  return extension_of(path) == "glb" ? "" : "what is written is GLB: its name must end in .glb";
}

int run(const Options& options) {
  catch_interruptions();
  const auto fail = [](const Error& error) {
    print_error(error.message);
    return exit_code(error.code);
  };
  const auto scene = generate_scene(options.name, options.scene);
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
  CLI::App app{"Generates a scene and writes it as GLB. The same options give the same bytes on every machine."};
  app.add_option("scene", options.name, "The scene to generate")
      ->required()
      ->check(CLI::IsMember({"sierpinski", "hairball", "forest"}).description(""))
      ->type_name("sierpinski|hairball|forest");
  app.add_option("-o,--output", options.output, "The file to write, named .glb")
      ->required()
      ->check(fault_of_name, "")
      ->type_name("PATH");
  add_common_options(app, options.common);
  add_generated_scene_options(app, options.scene, "--seed");
  return run_program(app, argc, argv, [&] { return run(options); });
}
