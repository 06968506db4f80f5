#include "judge.h"

#include <cstring>
#include <functional>
#include <stdexcept>
#include <string_view>

#include <vcd/format/wide_ray.h>

#include "shadows.h"

namespace vcd::render {

static_assert(sizeof(Segment) == 8 * sizeof(float), "no padding: its bytes tell it");

bool Judge::SameBits::operator()(const Segment& a, const Segment& b) const {
  return std::memcmp(&a, &b, sizeof a) == 0;
}
size_t Judge::SameBits::operator()(const Segment& s) const {
  return std::hash<std::string_view>{}({reinterpret_cast<const char*>(&s), sizeof s});
}

Judge::Judge(const World& world, std::span<const Object> objects) : world_(world) {
  for (const WorldObject& object : world.objects) referees_.emplace_back(object.mesh);
  if (!world.single()) scene_.emplace(scene_of(world, objects));
}

bool Judge::blocked(const Segment& segment) const {
  if (!scene_) return referees_[0].occluded(segment);
  const WideRay ray(segment);
  for (uint32_t i = 0; i < world_.instances.size(); ++i) {
    const WorldInstance& instance = world_.instances[i];
    const Vec3 low = instance.box.low, high = instance.box.high;
    const double min[3] = {low.x, low.y, low.z}, max[3] = {high.x, high.y, high.z};
    // What rounding may move a segment by is far below this.
    const auto room = [&](size_t a) { return 1e-4 * (max[a] - min[a]); };
    if (!ray.may_meet([&](size_t a) { return min[a] - room(a); }, [&](size_t a) { return max[a] + room(a); })) continue;
    const std::optional<Segment> moved = scene_->in_object(i, segment);
    if (!moved) throw std::runtime_error("a transform of the world has no inverse");
    if (referees_[instance.object].occluded(*moved)) return true;
  }
  return false;
}

void Judge::learn(std::span<const Segment> segments, std::span<const uint8_t> embree, std::span<uint8_t> truth) {
  for (size_t i = 0; i < segments.size(); ++i) {
    truth[i] = blocked(segments[i]);
    if (truth[i] == embree[i]) continue;
    const std::lock_guard lock(learning_);
    wrong_.insert_or_assign(segments[i], truth[i]);
  }
}

void Judge::correct(std::span<const Segment> segments, std::span<uint8_t> embree) const {
  for (size_t i = 0; i < segments.size(); ++i)
    if (const auto found = wrong_.find(segments[i]); found != wrong_.end()) embree[i] = found->second;
}

}  // namespace vcd::render
