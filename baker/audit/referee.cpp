#include <vcd/baker/referee.h>

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "audit/segment_triangle.h"

namespace vcd::baker {
namespace {

constexpr size_t kLeaf = 4;  // triangles that share a box

bool is_finite(const float (&v)[3]) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

}  // namespace

struct Referee::Query {
  const WideSegment segment;
  std::array<double, 3> reciprocal;
  std::vector<const Triangle*> doubtful;

  // No box that the segment meets is missed. Each distance is rounded three times (difference, reciprocal, product: no
  // over- or underflow between 2^-278 and 2^278), so it is within 4 e of itself; e = 2^-53. Twice that is taken off:
  // Ize, "Robust BVH ray traversal", 2013.
  bool may_meet(const Box& box) const {
    double enter = segment.t_min, leave = segment.t_max;
    for (int a = 0; a < 3; ++a) {
      const double low = box.min[a] - segment.origin[a], high = box.max[a] - segment.origin[a];
      if (segment.direction[a] == 0) {
        if (low > 0 || high < 0) return false;
        continue;
      }
      const double t0 = low * reciprocal[a], t1 = high * reciprocal[a];
      const double near = std::min(t0, t1), far = std::max(t0, t1);
      enter = std::max(enter, near - 0x1p-50 * std::abs(near));
      leave = std::min(leave, far + 0x1p-50 * std::abs(far));
    }
    return enter <= leave;
  }
};

Referee::Referee(const PreparedMesh& mesh) {
  triangles_.reserve(mesh.triangles.size());
  for (const TriangleIndices& t : mesh.triangles)
    triangles_.push_back({mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
  size_t leaves = 1;
  while (leaves * kLeaf < triangles_.size()) leaves *= 2;
  boxes_.resize(2 * leaves - 1);
  build(0, 0, triangles_.size());
}

void Referee::build(size_t node, size_t begin, size_t end) {
  Box& box = boxes_[node];
  box = {triangles_[begin][0], triangles_[begin][0]};
  for (size_t i = begin; i < end; ++i)
    for (const Position& p : triangles_[i])
      for (int a = 0; a < 3; ++a) {
        box.min[a] = std::min(box.min[a], p[a]);
        box.max[a] = std::max(box.max[a], p[a]);
      }
  if (2 * node + 1 >= boxes_.size()) return;
  int widest = 0;
  const auto extent = [&](int a) { return static_cast<double>(box.max[a]) - box.min[a]; };
  for (int a = 1; a < 3; ++a)
    if (extent(a) > extent(widest)) widest = a;
  const auto position = [&](const Triangle& t) {
    return static_cast<double>(t[0][widest]) + t[1][widest] + t[2][widest];
  };
  const size_t middle = begin + (end - begin) / 2;
  const auto at = [&](size_t i) { return triangles_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end),
                   [&](const Triangle& a, const Triangle& b) { return position(a) < position(b); });
  build(2 * node + 1, begin, middle);
  build(2 * node + 2, middle, end);
}

// True as soon as a triangle is certainly met; gathers the doubtful ones.
bool Referee::search(Query& query, size_t node, size_t begin, size_t end) const {
  if (!query.may_meet(boxes_[node])) return false;
  if (2 * node + 1 < boxes_.size()) {
    const size_t middle = begin + (end - begin) / 2;
    return search(query, 2 * node + 1, begin, middle) || search(query, 2 * node + 2, middle, end);
  }
  for (size_t i = begin; i < end; ++i) {
    const Meeting meeting = filter_meeting(query.segment, triangles_[i]);
    if (meeting == Meeting::yes) return true;
    if (meeting == Meeting::doubtful) query.doubtful.push_back(&triangles_[i]);
  }
  return false;
}

bool Referee::occluded(const Segment& segment) const {
  if (!(segment.t_min < segment.t_max) || !is_finite(segment.origin) || !is_finite(segment.direction)) return false;
  Query query{widen(segment), {}, {}};
  for (int a = 0; a < 3; ++a) query.reciprocal[a] = 1 / query.segment.direction[a];
  if (search(query, 0, 0, triangles_.size())) return true;
  return std::any_of(query.doubtful.begin(), query.doubtful.end(),
                     [&](const Triangle* triangle) { return meets_exactly(segment, *triangle); });
}

void Referee::occluded(std::span<const Segment> segments, std::span<uint8_t> blocked) const {
  tbb::parallel_for(size_t{0}, segments.size(), [&](size_t i) { blocked[i] = occluded(segments[i]); });
}

}  // namespace vcd::baker
