// The inner loops of the proofs, sixteen lanes at a time, in the best of several variants for the processor that runs
// them. All variants give the same bits: no multiply-add is fused, and no sum is reordered.
#pragma once

#include <cstddef>
#include <cstdint>

#include <vcd/baker/mesh.h>

#include "classify/shaft.h"

namespace vcd::baker {

struct alignas(64) TriangleCluster {
  float corner[3][3][kLanes];  // [corner][axis][lane], grid units; spare lanes repeat the last triangle
  uint32_t triangle[kLanes];
  uint32_t count;
};

struct alignas(64) ClusterGroup {
  float min[3][kLanes], max[3][kLanes];  // boxes of the clusters
  uint32_t first;                        // cluster of lane 0; the others follow
  uint32_t lanes;                        // bit k: lane k holds a cluster
};

// Some clusters of a group.
struct ClusterMask {
  uint32_t group;
  uint32_t lanes;  // bit k: the cluster of lane k
};

// Copies those clusters of `from` to `into` whose boxes no plane of the shaft separates from it; returns how many masks
// that are. into has room for `count`.
size_t select_clusters(const ClusterGroup* groups, const Shaft& shaft, const ClusterMask* from, size_t count,
                       ClusterMask* into);

// Bit k: no plane of the shaft separates triangle k from it.
uint32_t triangles_near(const Shaft& shaft, const TriangleCluster& cluster);

// Space seen along a line: coordinates on the axes first and second, where the line is the point (0, 0).
struct View {
  uint32_t main, first, second;  // axes; the line's direction is longest on main
  float from[3];                 // a point of the line
  float slope[2];                // of the line on first and second per unit on main; at most 1
};

// Bit k: the line passes triangle k's bounding rectangle in the view, grown by `margin`.
uint32_t triangles_around(const View& view, const TriangleCluster& cluster, float margin);

// A step of a flood: a triangle, entered across an edge whose ends are known.
struct alignas(64) FloodStep {
  float distance[2][kLanes];  // of the edge's ends from the shaft's planes
  uint32_t outside[2];        // bit k: outside plane k
  uint32_t vertex[2];
  uint32_t triangle;
};
struct FloodState {
  const Position* vertices;
  const TriangleIndices* triangles;
  const uint32_t* neighbour;  // pair_edges()
  uint32_t* stamps;           // a triangle's is `stamp` once it is reached
  uint32_t first_stamp, stamp;
  uint32_t limit;
  FloodStep* stack;    // room for limit + 4
  uint32_t* ended_at;  // a slot without a neighbour is written here when the flood fails there
};

// See Surface::flood.
bool flood_surface(const FloodState& state, const Shaft& shaft, uint32_t seed);

}  // namespace vcd::baker
