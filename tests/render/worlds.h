// Small scenes for the tests of the renderer.
#pragma once

#include <cstring>
#include <stdexcept>

#include <vcd/scenes/generate.h>

#include "render/renderer.h"
#include "render/sidecars.h"
#include "render/world.h"
#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {

using namespace render;

inline bool same_bits(const Image& a, const Image& b) {
  return a.pixels.size() == b.pixels.size() &&
         std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(Vec3)) == 0;
}

inline scenes::Mesh scene_mesh(baker::SourceMesh mesh) {
  return {std::move(mesh.name), std::move(mesh.positions), std::move(mesh.triangles), {0.7f, 0.7f, 0.7f}};
}

inline World must_build(scenes::Scene scene) {
  auto world = build_world(std::move(scene));
  if (!world) throw std::runtime_error(world.error().message);
  return std::move(*world);
}

inline World one_object(char up = 'y') { return must_build(scenes::around(scene_mesh(leaves(300)), up)); }

// Two objects in several places, turned and scaled.
inline World several_instances() {
  scenes::Scene scene = scenes::around(scene_mesh(leaves(120, 2)));
  scene.meshes.push_back(scene_mesh(sphere(8, 12)));
  scene.meshes[1].name = "ball";
  scene.instances.clear();
  for (uint32_t i = 0; i < 9; ++i) {
    const float c = std::cos(0.7f * static_cast<float>(i)), s = std::sin(0.7f * static_cast<float>(i));
    const float scale = 0.4f + 0.1f * static_cast<float>(i % 3);
    scene.instances.push_back({i % 2,
                               {c * scale, 0, s * scale, 2.0f * static_cast<float>(i % 3), 0, scale, 0, 1, -s * scale,
                                0, c * scale, 2.0f * static_cast<float>(i / 3) - 2}});
  }
  return must_build(std::move(scene));
}

inline RenderSettings small_picture(unsigned threads = 1) {
  RenderSettings settings;
  settings.width = 24, settings.height = 16, settings.pixel_samples = 4, settings.light_samples = 32,
  settings.threads = threads;
  return settings;
}

inline WorldSidecars must_bake(const World& world, const baker::BakeOptions& options, const TemporaryFolder& folder) {
  const auto baked =
      bake_world(world, options, folder / "world.vcd", [](const WorldObject&, const baker::BakeProgress&) {});
  if (!baked) throw std::runtime_error(baked.error().message);
  auto sidecars = open_sidecars(world, {(folder / "world.vcd").string()});
  if (!sidecars) throw std::runtime_error(sidecars.error().message);
  return std::move(*sidecars);
}

inline Rendered must_render(const World& world, const RenderSettings& settings, const MakeCaster& make) {
  auto rendered = render::render(world, settings, make);
  if (!rendered) throw std::runtime_error(rendered.error().message);
  return std::move(*rendered);
}

}  // namespace vcd::test
