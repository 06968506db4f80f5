#include "beam.h"

#include <algorithm>

namespace vcd::render {

Beam::Beam(std::span<const Segment> segments)
    : origin_{segments[0].origin[0], segments[0].origin[1], segments[0].origin[2]} {
  Box directions;
  for (const Segment& s : segments) directions.add(Vec3{s.direction[0], s.direction[1], s.direction[2]});
  const float low[3] = {directions.low.x, directions.low.y, directions.low.z};
  const float high[3] = {directions.high.x, directions.high.y, directions.high.z};
  for (int a = 0; a < 3; ++a) low_[a] = {low[a], 1 / low[a]}, high_[a] = {high[a], 1 / high[a]};
}

// At t, the beam covers origin + t · [low, high] on each axis. It overlaps the box on that axis where t · low ≤
// box.high - origin and t · high ≥ box.low - origin: two half-lines of t. All of them must have a t in common.
bool Beam::may_meet(const Box& box) const {
  const float below[3] = {box.low.x - origin_.x, box.low.y - origin_.y, box.low.z - origin_.z};
  const float above[3] = {box.high.x - origin_.x, box.high.y - origin_.y, box.high.z - origin_.z};
  float first = 0, last = 1;
  for (int a = 0; a < 3; ++a) {
    if (low_[a].slope > 0) {
      last = std::min(last, above[a] * low_[a].inverse);
    } else if (low_[a].slope < 0) {
      first = std::max(first, above[a] * low_[a].inverse);
    } else if (above[a] < 0) {
      return false;
    }
    if (high_[a].slope > 0) {
      first = std::max(first, below[a] * high_[a].inverse);
    } else if (high_[a].slope < 0) {
      last = std::min(last, below[a] * high_[a].inverse);
    } else if (below[a] > 0) {
      return false;
    }
  }
  return first <= last * (1 + 1e-5f);
}

}  // namespace vcd::render
