#include "sheet.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "classify/lanes.h"
#include "prepare/topology.h"

namespace vcd {
namespace {

// Whether an edge has a point inside all planes, given its ends' distances from them.
bool edge_meets(const float* from, uint32_t from_outside, const float* to, uint32_t to_outside) {
  if (from_outside & to_outside) return false;
  if (!from_outside || !to_outside) return true;
  float enter = 0, leave = 1;
  for (uint32_t planes = from_outside; planes; planes &= planes - 1) {
    const int k = std::countr_zero(planes);
    enter = std::max(enter, from[k] / (from[k] - to[k]));
  }
  for (uint32_t planes = to_outside; planes; planes &= planes - 1) {
    const int k = std::countr_zero(planes);
    leave = std::min(leave, from[k] / (from[k] - to[k]));
  }
  return enter <= leave;
}

}  // namespace

Surface::Surface(std::span<const Position> positions, std::span<const TriangleIndices> triangles,
                 std::vector<uint32_t> neighbour)
    : triangles_(triangles.begin(), triangles.end()), neighbour_(std::move(neighbour)) {
  for (const Position& p : positions) vertices_.push_back({p[0], p[1], p[2]});
}

void Surface::Flood::begin(size_t triangles) {
  stamps_.resize(triangles);
  if (stamp_ > 0xFFFF0000u) {  // after four billion floods
    std::fill(stamps_.begin(), stamps_.end(), 0u);
    stamp_ = 0;
  }
  first_ = stamp_ + 1;
}

bool Surface::flood(const Shaft& shaft, uint32_t seed, uint32_t limit, Flood& flood) const {
  ++flood.stamp_;
  auto& stack = flood.stack_;
  stack.clear();

  const auto measure = [&](uint32_t vertex, float* distance) {
    const Vertex& v = vertices_[vertex];
    Floats sum = lanes(shaft.normal[0]) * v.x + lanes(shaft.normal[1]) * v.y;
    sum += lanes(shaft.normal[2]) * v.z;
    sum -= lanes(shaft.offset);
    std::memcpy(distance, &sum, sizeof sum);
    return bits_of(sum > Floats{});
  };

  uint32_t reached = 1;
  flood.stamps_[seed] = flood.stamp_;
  // Goes on across edge `edge` of a triangle, whose ends are given; false at a boundary.
  const auto cross = [&](uint32_t triangle, uint32_t edge, uint32_t p, const float* dp, uint32_t op, uint32_t q,
                         const float* dq, uint32_t oq) {
    if (!edge_meets(dp, op, dq, oq)) return true;
    const uint32_t next = neighbour_[3 * size_t{triangle} + edge];
    if (next == kBoundary) return false;
    if (flood.reached(next)) return true;
    if (flood.reached_before(next)) return false;
    flood.stamps_[next] = flood.stamp_;
    ++reached;
    Flood::Step& step = stack.emplace_back();
    std::memcpy(step.distance[0], dp, sizeof step.distance[0]);
    std::memcpy(step.distance[1], dq, sizeof step.distance[1]);
    step.outside[0] = op, step.outside[1] = oq;
    step.vertex[0] = p, step.vertex[1] = q;
    step.triangle = next;
    return true;
  };

  alignas(64) float d[3][kLanes];
  uint32_t outside[3];
  const TriangleIndices& first = triangles_[seed];
  for (size_t c = 0; c < 3; ++c) outside[c] = measure(first[c], d[c]);
  for (uint32_t e = 0; e < 3; ++e) {
    const uint32_t f = (e + 1) % 3;
    if (!cross(seed, e, first[e], d[e], outside[e], first[f], d[f], outside[f])) return false;
  }
  while (!stack.empty()) {
    if (reached > limit) return false;
    const Flood::Step step = stack.back();
    stack.pop_back();
    const TriangleIndices& t = triangles_[step.triangle];
    uint32_t tip = 0;  // the corner that is not on the edge it was entered across
    while (t[tip] == step.vertex[0] || t[tip] == step.vertex[1]) ++tip;
    const uint32_t next = (tip + 1) % 3, previous = (tip + 2) % 3;
    const int n = t[next] == step.vertex[0] ? 0 : 1, p = 1 - n;
    outside[0] = measure(t[tip], d[0]);
    if (!cross(step.triangle, tip, t[tip], d[0], outside[0], t[next], step.distance[n], step.outside[n])) return false;
    if (!cross(step.triangle, previous, t[previous], step.distance[p], step.outside[p], t[tip], d[0], outside[0]))
      return false;
  }
  return true;
}

}  // namespace vcd
