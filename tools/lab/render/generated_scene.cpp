#include "generated_scene.h"

#include "common/memory.h"

namespace vcd::render {

using namespace tools;
namespace {

// What making a scene and its file takes at once: the arrays while they grow, and their copy in the file.
constexpr uint64_t kBytesPerTriangle = 48, kBytesPerTreeTriangle = 110, kBytesPerInstance = 1400;

uint64_t bytes_needed(const std::string& name, const GeneratedSceneOptions& options) {
  if (name == "sierpinski") return (uint64_t{4} << (2 * options.level)) * kBytesPerTriangle;
  if (name == "hairball") return scenes::hairball_triangles(options.hairball) * kBytesPerTriangle;
  return scenes::forest_mesh_triangles_bound(options.forest) * kBytesPerTreeTriangle +
         options.forest.instances * kBytesPerInstance;
}

}  // namespace

void add_generated_scene_options(CLI::App& app, GeneratedSceneOptions& options, const std::string& seed_flag) {
  const auto add = [&](const char* flag, uint32_t& value, const char* help, uint32_t low, uint32_t high) {
    app.add_option(flag, value, std::string(help) + " (default: " + std::to_string(value) + ")")
        ->check(CLI::Range(low, high))
        ->type_name("N")
        ->group("Generated scenes");
  };
  const uint32_t many = UINT32_MAX;
  add("--level", options.level, "sierpinski: 4^(level + 1) triangles", 0, 12);
  add("--strands", options.hairball.strands, "hairball: hairs", 1, many);
  add("--segments", options.hairball.segments, "hairball: pieces of a hair, lengthwise", 1, 100000);
  add("--sides", options.hairball.sides, "hairball: sides of a hair", 3, 1000);
  add("--instances", options.forest.instances, "forest: trees", 1, many);
  add("--species", options.forest.species, "forest: kinds of trees, one mesh each", 1, 4);
  add("--leaves", options.forest.leaves, "forest: leaves of one tree, about", 0, many);
  app.add_option_function<uint64_t>(
         seed_flag, [&](uint64_t seed) { options.hairball.seed = options.forest.seed = seed; },
         "hairball, forest: another seed, another scene (default: 1)")
      ->type_name("N")
      ->group("Generated scenes");
}

bool is_generated_scene(const std::string& name) {
  return name == "sierpinski" || name == "hairball" || name == "forest";
}

Result<scenes::Scene> generate_scene(const std::string& name, const GeneratedSceneOptions& options) {
  if (auto error = check_memory(name, bytes_needed(name, options))) return *error;
  if (name == "sierpinski") return scenes::sierpinski(options.level);
  return name == "hairball" ? scenes::hairball(options.hairball) : scenes::forest(options.forest);
}

}  // namespace vcd::render
