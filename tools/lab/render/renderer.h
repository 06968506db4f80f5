// Direct illumination by area lights, as in Billen and Dutré 2016, section 4: camera rays through the pixels, and from
// each point that they meet a bundle of shadow rays to each light.
#pragma once

#include <functional>

#include <vcd/format/error.h>

#include "image.h"
#include "shadows.h"
#include "world.h"

namespace vcd::render {

struct RenderSettings {
  uint32_t width = 480, height = 320;
  uint32_t pixel_samples = 16;   // camera rays a pixel, stratified
  uint32_t light_samples = 128;  // shadow rays from each point to each light, stratified; at most kMaxBundle
  unsigned threads = 0;          // 0: all
  bool pin = false;              // each thread to a processor of its own, where the system allows
  uint64_t seed = 1;             // of the jitter
};

struct RenderProgress {
  double fraction;           // of the picture
  uint64_t shadow_segments;  // cast so far
  double seconds;
};
struct RenderHooks {
  std::function<void(const RenderProgress&)> progress;  // now and then, from one thread at a time
  std::function<bool()> stop;                           // true ends the rendering with an error
};

struct Rendered {
  Image image;  // linear RGB
  uint64_t shadow_segments = 0;
  uint64_t object_samples = 0;  // camera rays that met an object
  double seconds = 0;           // wall time
  double shadow_seconds = 0;    // spent in cast(), all threads together
};

// Shadow rays are cast only where the surface and the light face one another, and where some ray of the bundle could
// meet the box of all that casts shadows: what a plain renderer would spare any caster. Surfaces are two-sided and
// matte. The same world and settings give the same segments, in the same bundles, for any caster and any number of
// threads. Errors: runtime (stopped).
Result<Rendered> render(const World& world, const RenderSettings& settings, const MakeCaster& make_caster,
                        const RenderHooks& hooks = {});

}  // namespace vcd::render
