#include "instance_tree.h"

#include <algorithm>
#include <numeric>

namespace vcd {

Beam::Beam(std::span<const Segment> segments)
    : origin_{segments[0].origin[0], segments[0].origin[1], segments[0].origin[2]} {
  Box directions;
  for (const Segment& s : segments) directions.add(Vec3{s.direction[0], s.direction[1], s.direction[2]});
  const float low[3] = {directions.low.x, directions.low.y, directions.low.z};
  const float high[3] = {directions.high.x, directions.high.y, directions.high.z};
  for (int a = 0; a < 3; ++a) low_[a] = {low[a], 1 / low[a]}, high_[a] = {high[a], 1 / high[a]};
}

// At t, the beam covers origin + t · [low, high] on each axis. It overlaps the box on that axis where t · low ≤ box.high - origin
// and t · high ≥ box.low - origin: two half-lines of t. All of them must have a t in common.
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

InstanceTree::InstanceTree(std::span<const Box> boxes) {
  std::vector<uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  if (!order.empty()) build(boxes, order);
}

// Split at the median of the centres along the widest axis.
void InstanceTree::build(std::span<const Box> boxes, std::span<uint32_t> order) {
  const size_t at = nodes_.size();
  nodes_.push_back({{}, 0, order.size() == 1 ? order[0] : kInterior});
  Box centers;
  for (uint32_t i : order) nodes_[at].box.add(boxes[i]), centers.add(boxes[i].center());
  if (order.size() == 1) return;
  const Vec3 extent = centers.high - centers.low;
  float Vec3::*const axis = extent.x >= extent.y && extent.x >= extent.z ? &Vec3::x : extent.y >= extent.z ? &Vec3::y : &Vec3::z;
  const size_t half = order.size() / 2;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                   [&](uint32_t a, uint32_t b) { return boxes[a].center().*axis < boxes[b].center().*axis; });
  build(boxes, order.first(half));
  nodes_[at].second = static_cast<uint32_t>(nodes_.size());
  build(boxes, order.subspan(half));
}

}  // namespace vcd
