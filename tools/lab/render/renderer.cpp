#include "renderer.h"

#include <limits>
#include <numbers>

#include "beam.h"
#include "sampling.h"
#include "surface.h"
#include "tiles.h"

namespace vcd::render {
namespace {

// Camera rays of one pixel, traced together.
class CameraRays {
 public:
  CameraRays(const World& world, const RenderSettings& settings)
      : world_(world), settings_(settings), strata_(make_strata(settings.pixel_samples)) {}

  // Calls visit(sample, point) for each ray that meets something; returns how many met nothing.
  template <class Visit>
  uint32_t trace(uint32_t x, uint32_t y, const Visit& visit) const {
    uint32_t missed = 0;
    for (uint32_t first = 0; first < settings_.pixel_samples; first += 16) {
      const uint32_t count = std::min(16u, settings_.pixel_samples - first);
      RTCRayHit16 rays;
      alignas(64) int valid[16];
      for (uint32_t k = 0; k < 16; ++k) {
        valid[k] = k < count ? -1 : 0;
        set_ray(rays, k, direction(x, y, first + std::min(k, count - 1)));
      }
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      rtcIntersect16(valid, world_.visible.get(), &context, &rays);
      for (uint32_t k = 0; k < count; ++k) {
        if (rays.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) {
          ++missed;
        } else {
          visit(first + k, surface_point(rays, k));
        }
      }
    }
    return missed;
  }

 private:
  Vec3 direction(uint32_t x, uint32_t y, uint32_t sample) const {
    const Sample2 j = jitter(settings_.seed, y * settings_.width + x, sample, 0xFFFFFFFF);
    const Sample2 corner = strata_.corners[sample];
    const float px = static_cast<float>(x) + corner.x + j.x * strata_.size.x;
    const float py = static_cast<float>(y) + corner.y + j.y * strata_.size.y;
    return camera_direction(world_.view, px, py, static_cast<float>(settings_.width),
                            static_cast<float>(settings_.height));
  }

  void set_ray(RTCRayHit16& rays, uint32_t k, Vec3 d) const {
    const Vec3 o = world_.view.position;
    rays.ray.org_x[k] = o.x, rays.ray.org_y[k] = o.y, rays.ray.org_z[k] = o.z;
    rays.ray.dir_x[k] = d.x, rays.ray.dir_y[k] = d.y, rays.ray.dir_z[k] = d.z;
    rays.ray.tnear[k] = 0, rays.ray.tfar[k] = std::numeric_limits<float>::infinity(), rays.ray.time[k] = 0;
    rays.ray.mask[k] = 0xFFFFFFFF, rays.ray.id[k] = 0, rays.ray.flags[k] = 0;
    rays.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
  }

  SurfacePoint surface_point(const RTCRayHit16& rays, uint32_t k) const {
    const Vec3 d{rays.ray.dir_x[k], rays.ray.dir_y[k], rays.ray.dir_z[k]};
    return render::surface_point(world_, world_.view.position, d, rays.ray.tfar[k],
                                 {rays.hit.Ng_x[k], rays.hit.Ng_y[k], rays.hit.Ng_z[k]}, rays.hit.instID[0][k],
                                 rays.hit.primID[k]);
  }

  const World& world_;
  const RenderSettings& settings_;
  Strata strata_;
};

class Worker : public TileWorker {
 public:
  Worker(const World& world, const RenderSettings& settings, std::unique_ptr<ShadowCaster> caster)
      : world_(world),
        settings_(settings),
        caster_(std::move(caster)),
        camera_(world, settings),
        strata_(make_strata(settings.light_samples)),
        segments_(settings.light_samples),
        u_(settings.light_samples),
        v_(settings.light_samples),
        weights_(settings.light_samples),
        blocked_(settings.light_samples) {}

  void draw(const Tile& tile, Image& image) override {
    for (uint32_t y = tile.y0; y < tile.y1; ++y)
      for (uint32_t x = tile.x0; x < tile.x1; ++x) image.pixels[size_t{y} * image.width + x] = pixel(x, y);
  }

 private:
  Vec3 pixel(uint32_t x, uint32_t y) {
    Vec3 sum;
    const uint32_t index = y * settings_.width + x;
    const uint32_t missed = camera_.trace(x, y, [&](uint32_t sample, const SurfacePoint& point) {
      Vec3 light_sum;
      for (uint32_t light = 0; light < world_.lights.size(); ++light)
        light_sum = light_sum + illumination(index, sample, light, point);
      sum = sum + light_sum * point.colour;
      object_samples += point.surface != kGroundSurface;
    });
    return (sum + kSky * static_cast<float>(missed)) * (1 / static_cast<float>(settings_.pixel_samples));
  }

  // Radiance that a white matte surface at the point sends back from one light.
  Vec3 illumination(uint32_t pixel, uint32_t sample, uint32_t light_index, const SurfacePoint& point) {
    const Light& light = world_.lights[light_index];
    const Vec3 origin = point.position + point.normal * world_.shadow_offset;
    const Sample2 j = jitter(settings_.seed, pixel, sample, light_index);
    size_t count = 0;
    for (const Sample2& corner : strata_.corners) {
      const float u = corner.x + j.x * strata_.size.x, v = corner.y + j.y * strata_.size.y;
      const Vec3 d = (light.quad.corner - origin) + light.quad.edge_u * u + light.quad.edge_v * v;
      const float at_surface = dot(d, point.normal), at_light = -dot(d, light.quad.normal);
      if (at_surface <= 0 || at_light <= 0) continue;
      const float squared = dot(d, d);
      segments_[count] = {{origin.x, origin.y, origin.z}, 0, {d.x, d.y, d.z}, 1};
      u_[count] = u, v_[count] = v;
      weights_[count++] = at_surface / squared * (at_light / squared);
    }
    if (count == 0) return {};
    const auto segments = std::span(segments_).first(count);
    if (Beam(segments).may_meet(world_.bounds)) {
      const Bundle bundle{
          segments,       std::span(u_).first(count), std::span(v_).first(count), light_index, pixel, point.surface,
          point.primitive};
      {
        const Stopwatch watch(shadow_seconds);
        caster_->cast(bundle, std::span(blocked_).first(count));
      }
      shadow_segments += count;
    } else {
      std::fill_n(blocked_.begin(), count, uint8_t{0});
    }
    float sum = 0;
    for (size_t i = 0; i < count; ++i) sum += blocked_[i] ? 0 : weights_[i];
    return light.radiance *
           (sum * light.quad.area * std::numbers::inv_pi_v<float> / static_cast<float>(settings_.light_samples));
  }

  const World& world_;
  const RenderSettings& settings_;
  std::unique_ptr<ShadowCaster> caster_;
  CameraRays camera_;
  Strata strata_;
  std::vector<Segment> segments_;
  std::vector<float> u_, v_;  // where on the light they end
  std::vector<float> weights_;
  std::vector<uint8_t> blocked_;
};

}  // namespace

Result<Rendered> render(const World& world, const RenderSettings& settings, const MakeCaster& make_caster,
                        const RenderHooks& hooks) {
  constexpr uint32_t kTile = 8;
  return draw_tiles(
      world, settings, kTile, [&] { return std::make_unique<Worker>(world, settings, make_caster()); }, hooks);
}

}  // namespace vcd::render
