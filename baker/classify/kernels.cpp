#include "classify/kernels.h"

// This file is compiled once for each kind of processor.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "classify/kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes-inl.h"
#include "prepare/topology.h"

HWY_BEFORE_NAMESPACE();
namespace vcd::baker {
namespace HWY_NAMESPACE {

// n · x in one order for all variants.
HWY_INLINE Floats dot(Floats nx, Floats x, Floats ny, Floats y, Floats nz, Floats z) {
  return hn::Add(hn::Add(hn::Mul(nx, x), hn::Mul(ny, y)), hn::Mul(nz, z));
}

size_t SelectClusters(const ClusterGroup* groups, const Shaft& shaft, const ClusterMask* from, size_t count,
                      ClusterMask* into) {
  size_t selected = 0;
  for (size_t c = 0; c < count; ++c) {
    const ClusterGroup& group = groups[from[c].group];
    uint32_t outside = 0;
    for (size_t i = 0; i < kLanes; i += kStep) {
      Truth out = never();
      for (uint32_t k = 0; k < shaft.planes; ++k) {
        // The corner of each box that lies deepest inside the plane.
        const float nx = shaft.normal[0][k], ny = shaft.normal[1][k], nz = shaft.normal[2][k];
        const Floats nearest = dot(all(nx), load((nx > 0 ? group.min[0] : group.max[0]) + i), all(ny),
                                   load((ny > 0 ? group.min[1] : group.max[1]) + i), all(nz),
                                   load((nz > 0 ? group.min[2] : group.max[2]) + i));
        out = hn::Or(out, hn::Gt(nearest, all(shaft.offset[k])));
      }
      outside |= bits_of(out) << i;
    }
    const uint32_t left = from[c].lanes & ~outside;
    into[selected] = {from[c].group, left};
    selected += left != 0;
  }
  return selected;
}

uint32_t TrianglesNear(const Shaft& shaft, const TriangleCluster& cluster) {
  uint32_t outside = 0;
  for (size_t i = 0; i < kLanes; i += kStep) {
    Truth out = never();
    for (uint32_t k = 0; k < shaft.planes; ++k) {
      const Floats nx = all(shaft.normal[0][k]), ny = all(shaft.normal[1][k]), nz = all(shaft.normal[2][k]);
      const auto beyond = [&](const float(&corner)[3][kLanes]) HWY_ATTR {
        return hn::Gt(dot(nx, load(corner[0] + i), ny, load(corner[1] + i), nz, load(corner[2] + i)),
                      all(shaft.offset[k]));
      };
      out = hn::Or(out,
                   hn::And(hn::And(beyond(cluster.corner[0]), beyond(cluster.corner[1])), beyond(cluster.corner[2])));
    }
    outside |= bits_of(out) << i;
  }
  return ~outside & ((1u << cluster.count) - 1);
}

uint32_t TrianglesAround(const View& view, const TriangleCluster& cluster, float margin) {
  uint32_t around = 0;
  const uint32_t axes[2] = {view.first, view.second};
  for (size_t i = 0; i < kLanes; i += kStep) {
    Truth near = hn::FirstN(Tag(), kStep);
    for (int n = 0; n < 2; ++n) {
      const auto seen = [&](const float(&corner)[3][kLanes]) HWY_ATTR {
        return hn::Sub(hn::Sub(load(corner[axes[n]] + i), all(view.from[axes[n]])),
                       hn::Mul(hn::Sub(load(corner[view.main] + i), all(view.from[view.main])), all(view.slope[n])));
      };
      const Floats x = seen(cluster.corner[0]), y = seen(cluster.corner[1]), z = seen(cluster.corner[2]);
      near = hn::And(near, hn::Le(hn::Min(hn::Min(x, y), z), all(margin)));
      near = hn::And(near, hn::Ge(hn::Max(hn::Max(x, y), z), all(-margin)));
    }
    around |= bits_of(near) << i;
  }
  return around & ((1u << cluster.count) - 1);
}

// Distances of a vertex from the planes; bit k of the result: outside plane k.
HWY_INLINE uint32_t measure(const Shaft& shaft, const Position& vertex, float* distance) {
  uint32_t outside = 0;
  for (size_t i = 0; i < kLanes; i += kStep) {
    const Floats d = hn::Sub(dot(load(shaft.normal[0] + i), all(vertex[0]), load(shaft.normal[1] + i), all(vertex[1]),
                                 load(shaft.normal[2] + i), all(vertex[2])),
                             load(shaft.offset + i));
    hn::Store(d, Tag(), distance + i);
    outside |= bits_of(hn::Gt(d, hn::Zero(Tag()))) << i;
  }
  return outside;
}

// Whether an edge has a point inside all planes, given its ends.
HWY_INLINE bool edge_meets(const float* from, uint32_t from_outside, const float* to, uint32_t to_outside) {
  if (from_outside & to_outside) return false;
  if (!from_outside || !to_outside) return true;
  float enter = 0, leave = 1;
  for (uint32_t planes = from_outside; planes; planes &= planes - 1) {
    const int k = __builtin_ctz(planes);
    const float at = from[k] / (from[k] - to[k]);
    enter = at > enter ? at : enter;
  }
  for (uint32_t planes = to_outside; planes; planes &= planes - 1) {
    const int k = __builtin_ctz(planes);
    const float at = from[k] / (from[k] - to[k]);
    leave = at < leave ? at : leave;
  }
  return enter <= leave;
}

HWY_INLINE void copy_lanes(const float* from, float* to) {
  for (size_t i = 0; i < kLanes; i += kStep) hn::Store(load(from + i), Tag(), to + i);
}

struct End {
  const float* distance;
  uint32_t outside;
  uint32_t vertex;
};

bool FloodSurface(const FloodState& state, const Shaft& shaft, uint32_t seed) {
  size_t depth = 0;
  uint32_t reached = 1;
  state.stamps[seed] = state.stamp;
  // Goes on across an edge of a triangle; false where the flood has failed.
  const auto cross = [&](uint32_t triangle, uint32_t edge, const End& p, const End& q) HWY_ATTR {
    if (!edge_meets(p.distance, p.outside, q.distance, q.outside)) return true;
    const uint32_t next = state.neighbour[3 * size_t{triangle} + edge];
    if (next == kBoundary) *state.ended_at = 3 * triangle + edge;
    if (next == kBoundary) return false;
    if (state.stamps[next] == state.stamp) return true;
    if (state.stamps[next] >= state.first_stamp || reached >= state.limit) return false;
    state.stamps[next] = state.stamp;
    ++reached;
    FloodStep& step = state.stack[depth++];
    copy_lanes(p.distance, step.distance[0]);
    copy_lanes(q.distance, step.distance[1]);
    step.outside[0] = p.outside, step.outside[1] = q.outside;
    step.vertex[0] = p.vertex, step.vertex[1] = q.vertex;
    step.triangle = next;
    return true;
  };

  alignas(64) float distance[3][kLanes];
  End end[3];
  for (int c = 0; c < 3; ++c) {
    const uint32_t vertex = state.triangles[seed][static_cast<size_t>(c)];
    end[c] = {distance[c], measure(shaft, state.vertices[vertex], distance[c]), vertex};
  }
  for (uint32_t e = 0; e < 3; ++e)
    if (!cross(seed, e, end[e], end[(e + 1) % 3])) return false;

  while (depth > 0) {
    const FloodStep step = state.stack[--depth];
    const TriangleIndices& t = state.triangles[step.triangle];
    uint32_t tip = 0;  // the corner that is not on the edge it was entered across
    while (t[tip] == step.vertex[0] || t[tip] == step.vertex[1]) ++tip;
    const uint32_t previous = (tip + 2) % 3;
    const int after = t[(tip + 1) % 3] == step.vertex[0] ? 0 : 1, before = 1 - after;
    const End apex = {distance[0], measure(shaft, state.vertices[t[tip]], distance[0]), t[tip]};
    const End next_end = {step.distance[after], step.outside[after], step.vertex[after]};
    const End previous_end = {step.distance[before], step.outside[before], step.vertex[before]};
    if (!cross(step.triangle, tip, apex, next_end)) return false;
    if (!cross(step.triangle, previous, previous_end, apex)) return false;
  }
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd::baker
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vcd::baker {

HWY_EXPORT(SelectClusters);
HWY_EXPORT(TrianglesNear);
HWY_EXPORT(TrianglesAround);
HWY_EXPORT(FloodSurface);

size_t select_clusters(const ClusterGroup* groups, const Shaft& shaft, const ClusterMask* from, size_t count,
                       ClusterMask* into) {
  return HWY_DYNAMIC_DISPATCH(SelectClusters)(groups, shaft, from, count, into);
}
uint32_t triangles_near(const Shaft& shaft, const TriangleCluster& cluster) {
  return HWY_DYNAMIC_DISPATCH(TrianglesNear)(shaft, cluster);
}
uint32_t triangles_around(const View& view, const TriangleCluster& cluster, float margin) {
  return HWY_DYNAMIC_DISPATCH(TrianglesAround)(view, cluster, margin);
}
bool flood_surface(const FloodState& state, const Shaft& shaft, uint32_t seed) {
  return HWY_DYNAMIC_DISPATCH(FloodSurface)(state, shaft, seed);
}

}  // namespace vcd::baker
#endif
