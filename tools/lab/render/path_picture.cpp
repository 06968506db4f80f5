#include "path_picture.h"

#include <limits>

#include "sampling.h"
#include "surface.h"
#include "tiles.h"

namespace vcd::render {
namespace {

constexpr uint32_t kTile = 16;  // with 16 paths a pixel, one wavefront

class PathWorker : public TileWorker {
 public:
  PathWorker(const World& world, const RenderSettings& settings, const PathPicture& paths,
             std::unique_ptr<PathCaster> caster)
      : world_(world),
        settings_(settings),
        paths_(paths),
        caster_(std::move(caster)),
        strata_(make_strata(settings.pixel_samples)) {}

  void draw(const Tile& tile, Image& image) override {
    Random random(settings_.seed + (uint64_t{tile.index} << 32));
    for (uint32_t y = tile.y0; y < tile.y1; ++y)
      for (uint32_t x = tile.x0; x < tile.x1; ++x)
        for (const Sample2& corner : strata_.corners) {
          follow(random, direction(random, x, y, corner), image.pixels[size_t{y} * image.width + x]);
          if (pixels_.size() == kWavefront) cast();
        }
    cast();
  }

 private:
  Vec3 direction(Random& random, uint32_t x, uint32_t y, Sample2 corner) const {
    const Sample2 inside = random_sample(random);
    return camera_direction(world_.view, static_cast<float>(x) + corner.x + inside.x * strata_.size.x,
                            static_cast<float>(y) + corner.y + inside.y * strata_.size.y,
                            static_cast<float>(settings_.width), static_cast<float>(settings_.height));
  }

  void follow(Random& random, Vec3 direction, Vec3& pixel) {
    const auto path = static_cast<uint32_t>(pixels_.size());
    pixels_.push_back(&pixel);
    const Met met = trace_path(world_, random, path, direction, paths_.bounces, rays_);
    if (met == Met::nothing) add(pixel, kSky);
    object_samples += met == Met::object;
  }

  void add(Vec3& pixel, Vec3 light) const { pixel = pixel + light * (1 / static_cast<float>(settings_.pixel_samples)); }

  // What was followed since the last time.
  void cast() {
    if (paths_.wavefronts) sort_as_wavefronts(rays_);
    const AskedRays asked(rays_);
    blocked_.resize(rays_.size());
    {
      const Stopwatch watch(shadow_seconds);
      caster_->cast(asked, blocked_);
    }
    for (size_t i = 0; i < rays_.size(); ++i)
      if (!blocked_[i]) add(*pixels_[rays_[i].path], rays_[i].light);
    shadow_segments += rays_.size();
    rays_.clear(), pixels_.clear();
  }

  const World& world_;
  const RenderSettings& settings_;
  const PathPicture& paths_;
  std::unique_ptr<PathCaster> caster_;
  Strata strata_;
  std::vector<PathRay> rays_;
  std::vector<Vec3*> pixels_;  // by path
  std::vector<uint8_t> blocked_;
};

}  // namespace

Result<Rendered> render_paths(const World& world, const RenderSettings& settings, const PathPicture& paths,
                              const MakePathCaster& make_caster, const RenderHooks& hooks) {
  return draw_tiles(
      world, settings, kTile, [&] { return std::make_unique<PathWorker>(world, settings, paths, make_caster()); },
      hooks);
}

EmbreeQuery fastest_way(const World& world, const RenderSettings& settings, const PathPicture& paths) {
  RenderSettings small = settings;
  small.width = 48, small.height = 32, small.pixel_samples = 16, small.seed = ~settings.seed;
  EmbreeQuery best{1};
  double least = std::numeric_limits<double>::infinity();
  for (const EmbreeQuery& way : world.ways_to_trace()) {
    if ((way.width > 1) != paths.wavefronts || (way.width == 1 && way.coherent)) continue;
    const auto rendered = render_paths(world, small, paths, [&] { return std::make_unique<BvhPaths>(world, way); });
    if (rendered->shadow_seconds >= least) continue;
    least = rendered->shadow_seconds, best = way;
  }
  return best;
}

}  // namespace vcd::render
