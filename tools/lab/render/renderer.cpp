#include "renderer.h"

#include <atomic>
#include <chrono>
#include <limits>
#include <mutex>
#include <thread>

#include <pthread.h>
#include <sched.h>

#include "beam.h"
#include "common/limits.h"
#include "sampling.h"
#include "surface.h"

namespace vcd::render {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_between(Clock::time_point a, Clock::time_point b) {
  return std::chrono::duration<double>(b - a).count();
}

constexpr uint32_t kTile = 8;                       // pixels along a tile's side
constexpr Vec3 kBackground = {0.55f, 0.65f, 0.8f};  // where a camera ray meets nothing

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

// One thread's share of the work.
class Worker {
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
    return (sum + kBackground * static_cast<float>(missed)) * (1 / static_cast<float>(settings_.pixel_samples));
  }

  uint64_t shadow_segments = 0, object_samples = 0;
  double shadow_seconds = 0;

 private:
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
      const Clock::time_point start = Clock::now();
      caster_->cast(
          {segments, std::span(u_).first(count), std::span(v_).first(count), light_index, pixel, point.surface},
          std::span(blocked_).first(count));
      shadow_seconds += seconds_between(start, Clock::now());
      shadow_segments += count;
    } else {
      std::fill_n(blocked_.begin(), count, uint8_t{0});
    }
    float sum = 0;
    for (size_t i = 0; i < count; ++i) sum += blocked_[i] ? 0 : weights_[i];
    constexpr float kInversePi = 0.318309886f;
    return light.radiance * (sum * light.quad.area * kInversePi / static_cast<float>(settings_.light_samples));
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

void pin_to(unsigned index) {
  cpu_set_t allowed, one;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;
  const unsigned wanted = index % static_cast<unsigned>(std::max(CPU_COUNT(&allowed), 1));
  unsigned seen = 0;
  for (size_t cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (!CPU_ISSET(cpu, &allowed) || seen++ != wanted) continue;
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    pthread_setaffinity_np(pthread_self(), sizeof one, &one);
    return;
  }
}

}  // namespace

Result<Rendered> render(const World& world, const RenderSettings& settings, const MakeCaster& make_caster,
                        const RenderHooks& hooks) {
  const unsigned threads = settings.threads ? settings.threads : tools::available_processors();
  std::vector<Worker> workers;
  for (unsigned t = 0; t < threads; ++t) workers.emplace_back(world, settings, make_caster());

  Rendered rendered;
  rendered.image = Image(settings.width, settings.height);
  const uint32_t columns = (settings.width + kTile - 1) / kTile, rows = (settings.height + kTile - 1) / kTile;
  std::atomic<uint32_t> next_tile = 0;
  std::atomic<uint64_t> segments = 0;
  std::atomic<bool> stopped = false;
  std::mutex reporting;
  const Clock::time_point start = Clock::now();

  const auto work = [&](unsigned index) {
    if (settings.pin) pin_to(index);
    Worker& worker = workers[index];
    for (uint32_t tile; !stopped && (tile = next_tile++) < columns * rows;) {
      if (hooks.stop && hooks.stop()) stopped = true;
      const uint32_t x0 = tile % columns * kTile, y0 = tile / columns * kTile;
      const uint64_t before = worker.shadow_segments;
      for (uint32_t y = y0; y < std::min(y0 + kTile, settings.height); ++y)
        for (uint32_t x = x0; x < std::min(x0 + kTile, settings.width); ++x)
          rendered.image.pixels[size_t{y} * settings.width + x] = worker.pixel(x, y);
      segments += worker.shadow_segments - before;
      if (const std::unique_lock lock(reporting, std::try_to_lock); lock && hooks.progress)
        hooks.progress({(tile + 1.0) / (columns * rows), segments, seconds_between(start, Clock::now())});
    }
  };
  {
    std::vector<std::jthread> pool;
    for (unsigned t = 0; t < threads; ++t) pool.emplace_back(work, t);
  }
  if (stopped) return Error{ErrorCode::runtime, world.name + ": stopped"};
  rendered.seconds = seconds_between(start, Clock::now());
  for (const Worker& worker : workers) {
    rendered.shadow_segments += worker.shadow_segments;
    rendered.object_samples += worker.object_samples;
    rendered.shadow_seconds += worker.shadow_seconds;
  }
  return rendered;
}

}  // namespace vcd::render
