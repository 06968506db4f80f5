#include "path_casters.h"

#include <algorithm>
#include <tuple>

namespace vcd::render {

AskedRays::AskedRays(std::span<const PathRay> rays) {
  const auto together = [](const PathRay& a, const PathRay& b) {
    return std::tuple(a.path / kWavefront, a.bounce, a.from) == std::tuple(b.path / kWavefront, b.bounce, b.from);
  };
  const PathRay* before = nullptr;
  for (const PathRay& ray : rays) {
    if (!before || !together(*before, ray)) arrays.push_back({segments.size(), 0});
    before = &ray;
    ++arrays.back().count;
    segments.push_back(ray.segment), from.push_back(ray.from), primitives.push_back(ray.primitive);
    origins.push_back(ray.surface == kGroundSurface ? kNoInstance : ray.surface);
  }
}

void sort_as_wavefronts(std::vector<PathRay>& rays) {
  std::ranges::stable_sort(rays, {},
                           [](const PathRay& r) { return std::tuple(r.path / kWavefront, r.bounce, r.from); });
}

SidecarPaths::SidecarPaths(const World& world, std::span<const Object> objects, bool by_horizons)
    : by_horizons_(by_horizons) {
  if (world.single()) object_ = objects[0];
  else scene_.emplace(scene_of(world, objects));
  for (const WorldInstance& instance : world.instances)
    hierarchies_.push_back(world.objects[instance.object].tracer.scene());
}

void SidecarPaths::occluded(const AskedRays& rays, AskedRays::Array array, std::span<uint64_t> blocked) const {
  const auto segments = std::span(rays.segments).subspan(array.first, array.count);
  if (object_ && by_horizons_ && rays.from[array.first] == From::self)
    object_->occluded_self(segments, std::span(rays.primitives).subspan(array.first, array.count), blocked);
  else if (object_) object_->occluded(segments, blocked, rays.from[array.first]);
  else scene_->occluded(segments, blocked, query(rays, array));
}

bool SidecarPaths::occluded_by(RTCScene casters, const AskedRays& rays, size_t i) const {
  RTCRay ray = to_ray(rays.segments[i]);
  if (object_) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    occluded1(*object_, casters, &context, &ray);
  } else {
    occluded1(*scene_, EmbreeInstances{hierarchies_, {1}}, &ray, query(rays, {i, 1}));
  }
  return ray.tfar < 0;
}

void BvhPaths::cast(const AskedRays& rays, std::span<uint8_t> blocked) {
  for (const auto& [first, count] : rays.arrays)
    vcd::occluded(casters_, way_, std::span(rays.segments).subspan(first, count), blocked.data() + first);
}

void HierarchyPaths::cast(const AskedRays& rays, std::span<uint8_t> blocked) {
  if (!wavefronts_) {
    for (size_t i = 0; i < rays.segments.size(); ++i) blocked[i] = paths_.occluded(rays, i);
    return;
  }
  uint64_t bits[kWavefront / 64];
  for (const AskedRays::Array& array : rays.arrays) {
    paths_.occluded(rays, array, bits);
    for (size_t i = 0; i < array.count; ++i) blocked[array.first + i] = bits[i / 64] >> (i % 64) & 1;
  }
}

}  // namespace vcd::render
