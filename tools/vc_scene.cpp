// vc-scene: writes a generated scene as GLB, for vc-bake and for any other program that reads glTF.
#include <cstdio>
#include <stdexcept>

#include <vcd/format/atomic_file.h>
#include <vcd/scenes/generate.h>
#include <vcd/scenes/glb.h>

#include "common/describe.h"
#include "common/memory.h"
#include "common/program.h"
#include "common/progress.h"

namespace {

using namespace vcd;

struct Options {
  CommonOptions common;
  std::string output;
  uint32_t level = 8;
  scenes::HairballOptions hairball;
  scenes::ForestOptions forest;
};

// What making the scene and its file takes at once: the arrays while they grow, and their copy in the file.
constexpr uint64_t kBytesPerTriangle = 48, kBytesPerTreeTriangle = 110, kBytesPerInstance = 1400;

Result<scenes::Scene> make_scene(const std::string& name, const Options& options) {
  if (name == "sierpinski") {
    const uint64_t triangles = uint64_t{4} << (2 * options.level);
    if (auto error = check_memory(name, triangles * kBytesPerTriangle)) return *error;
    return scenes::sierpinski(options.level);
  }
  if (name == "hairball") {
    const uint64_t triangles = scenes::hairball_triangles(options.hairball);
    if (auto error = check_memory(name, triangles * kBytesPerTriangle)) return *error;
    return scenes::hairball(options.hairball);
  }
  const uint64_t triangles = scenes::forest_mesh_triangles_bound(options.forest);
  const uint64_t bytes = triangles * kBytesPerTreeTriangle + options.forest.instances * kBytesPerInstance;
  if (auto error = check_memory(name, bytes)) return *error;
  return scenes::forest(options.forest);
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

int run(const std::string& name, const Options& options) {
  catch_interruptions();
  const auto fail = [](const Error& error) {
    print_error(error.message);
    return exit_code(error.code);
  };
  const auto scene = make_scene(name, options);
  if (!scene) return fail(scene.error());
  const auto glb = glb_of(*scene);
  if (!glb) return fail(glb.error());
  const auto written = write(options.output, *glb);
  if (!written) return fail(written.error());
  report(options, *scene, *written);
  return kExitOk;
}

template <class T>
void add_number(CLI::App* app, const std::string& flag, T& value, const std::string& help, T low, T high) {
  app->add_option(flag, value, help)->check(CLI::Range(low, high))->type_name("N")->capture_default_str();
}

void add_scenes(CLI::App& app, Options& options) {
  const uint32_t many = UINT32_MAX;
  CLI::App* sierpinski = app.add_subcommand("sierpinski", "Sierpinski's pyramid");
  add_number(sierpinski, "--level", options.level, "4^(level + 1) triangles", 0u, 12u);

  CLI::App* hairball = app.add_subcommand("hairball", "A ball of curled hair");
  add_number(hairball, "--strands", options.hairball.strands, "Hairs", 1u, many);
  add_number(hairball, "--segments", options.hairball.segments, "Pieces of a hair, lengthwise", 1u, 100000u);
  add_number(hairball, "--sides", options.hairball.sides, "Sides of a hair", 3u, 1000u);
  add_number(hairball, "--seed", options.hairball.seed, "Another seed, another ball", uint64_t{0}, UINT64_MAX);

  CLI::App* forest = app.add_subcommand("forest", "A wood of several species");
  add_number(forest, "--instances", options.forest.instances, "Trees", 1u, many);
  add_number(forest, "--species", options.forest.species, "Kinds of trees, one mesh each", 1u, 4u);
  add_number(forest, "--leaves", options.forest.leaves, "Leaves of one tree, about", 0u, many);
  add_number(forest, "--seed", options.forest.seed, "Another seed, another wood", uint64_t{0}, UINT64_MAX);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Generates a scene and writes it as GLB. The same options give the same bytes on every machine."};
  app.require_subcommand(1);
  app.fallthrough();  // so that common options may also stand behind the scene
  app.add_option("-o,--output", options.output, "The file to write")->required()->type_name("PATH");
  add_common_options(app, options.common);
  add_scenes(app, options);
  return run_program(app, argc, argv, [&] { return run(app.get_subcommands()[0]->get_name(), options); });
}
