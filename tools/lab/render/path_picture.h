// A picture by path tracing: diffuse bounces, one shadow ray at each surface point, to a light or to the sky.
#pragma once

#include <functional>
#include <memory>

#include "path_casters.h"
#include "renderer.h"

namespace vcd::render {

struct PathPicture {
  uint32_t bounces = kMostBounces;  // 1 … kMostBounces: surface points of a path
  bool wavefronts = false;          // shadow rays of kWavefront paths are cast together; else path by path
};

// One a thread; made before the threads start.
using MakePathCaster = std::function<std::unique_ptr<PathCaster>()>;

// settings.pixel_samples are paths a pixel; settings.light_samples has no meaning. The same world and settings give the
// same shadow rays for any caster and any number of threads. Errors: runtime (stopped).
Result<Rendered> render_paths(const World& world, const RenderSettings& settings, const PathPicture& paths,
                              const MakePathCaster& make_caster, const RenderHooks& hooks = {});

// Embree's fastest way, tried on a small picture with another seed: one ray a call, or as many at once as wavefronts
// allow.
EmbreeQuery fastest_way(const World& world, const RenderSettings& settings, const PathPicture& paths);

}  // namespace vcd::render
