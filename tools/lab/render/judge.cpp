#include "judge.h"

#include <cstring>
#include <functional>
#include <string_view>

namespace vcd::render {

static_assert(sizeof(Segment) == 8 * sizeof(float), "no padding: its bytes tell it");

bool Judge::SameBits::operator()(const Segment& a, const Segment& b) const {
  return std::memcmp(&a, &b, sizeof a) == 0;
}
size_t Judge::SameBits::operator()(const Segment& s) const {
  return std::hash<std::string_view>{}({reinterpret_cast<const char*>(&s), sizeof s});
}

void Judge::learn(std::span<const Segment> segments, std::span<const uint8_t> embree, std::span<uint8_t> truth) {
  for (size_t i = 0; i < segments.size(); ++i) {
    truth[i] = referee_.occluded(segments[i]);
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
