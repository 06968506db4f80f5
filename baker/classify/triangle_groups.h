// The triangles of a mesh in clusters of sixteen, and those in groups of sixteen, so that a whole cluster or group is
// held against a shaft at once.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include <vcd/baker/mesh.h>

#include "classify/kernels.h"
#include "classify/shaft.h"

namespace vcd::baker {

// Clusters that may meet a shaft.
using Candidates = std::vector<ClusterMask>;

class TriangleGroups {
 public:
  // Positions in grid units. Neighbouring triangles get into one cluster: median splits along the longest axis.
  TriangleGroups(std::span<const Position> positions, std::span<const TriangleIndices> triangles);

  Candidates all() const;
  // Of these, the clusters whose boxes no plane of the shaft separates from it.
  void select(const Shaft& shaft, const Candidates& from, Candidates& into) const;
  // Whether a triangle of these clusters meets the shaft. Never false for one that does.
  bool any_meets(const Shaft& shaft, const Candidates& candidates) const;

  // visit(const TriangleCluster&) for each of them until it returns false.
  template <class Visit>
  void for_each(std::span<const ClusterMask> candidates, const Visit& visit) const {
    for (const ClusterMask& candidate : candidates)
      for (uint32_t rest = candidate.lanes; rest; rest &= rest - 1)
        if (!visit(clusters_[groups_[candidate.group].first + static_cast<uint32_t>(std::countr_zero(rest))])) return;
  }

 private:
  std::vector<TriangleCluster> clusters_;
  std::vector<ClusterGroup> groups_;
};

// Whether a triangle meets a shaft: it is cut by all planes, and something is left.
bool triangle_meets(const Shaft& shaft, const Position& p, const Position& q, const Position& r);

}  // namespace vcd::baker
