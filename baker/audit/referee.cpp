#include <vcd/baker/referee.h>

#include <algorithm>

#include <tbb/parallel_for.h>

#include <vcd/format/wide_ray.h>

namespace vcd::baker {
namespace {

constexpr size_t kLeaf = 4;  // triangles that share a box

}  // namespace

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

bool Referee::search(const Segment& segment, const WideRay& ray, size_t node, size_t begin, size_t end) const {
  const Box& box = boxes_[node];
  if (!ray.may_meet([&](size_t a) { return static_cast<double>(box.min[a]); },
                    [&](size_t a) { return static_cast<double>(box.max[a]); }))
    return false;
  if (2 * node + 1 < boxes_.size()) {
    const size_t middle = begin + (end - begin) / 2;
    return search(segment, ray, 2 * node + 1, begin, middle) || search(segment, ray, 2 * node + 2, middle, end);
  }
  return std::any_of(triangles_.begin() + static_cast<std::ptrdiff_t>(begin),
                     triangles_.begin() + static_cast<std::ptrdiff_t>(end),
                     [&](const Triangle& triangle) { return meets(segment, triangle); });
}

bool Referee::occluded(const Segment& segment) const {
  return can_meet(segment) && search(segment, WideRay(segment), 0, 0, triangles_.size());
}

void Referee::occluded(std::span<const Segment> segments, std::span<uint8_t> blocked) const {
  tbb::parallel_for(size_t{0}, segments.size(), [&](size_t i) { blocked[i] = occluded(segments[i]); });
}

}  // namespace vcd::baker
