#include "sheet.h"

#include <algorithm>
#include <utility>

#include "prepare/topology.h"

namespace vcd::baker {

Surface::Surface(std::span<const Position> positions, std::span<const TriangleIndices> triangles,
                 std::vector<uint32_t> neighbour)
    : vertices_(positions), triangles_(triangles), neighbour_(std::move(neighbour)) {}

void Surface::Flood::begin(size_t triangles) {
  stamps_.resize(triangles);
  if (stamp_ > 0xFFFF0000u) {  // after four billion floods
    std::fill(stamps_.begin(), stamps_.end(), 0u);
    stamp_ = 0;
  }
  first_ = stamp_ + 1;
  ended_at_ = kBoundary;
}

bool Surface::flood(const Shaft& shaft, uint32_t seed, uint32_t limit, Flood& flood) const {
  flood.stack_.resize(std::max<size_t>(flood.stack_.size(), limit + 4));
  ++flood.stamp_;
  const FloodState state{vertices_.data(),
                         triangles_.data(),
                         neighbour_.data(),
                         flood.stamps_.data(),
                         flood.first_,
                         flood.stamp_,
                         limit,
                         flood.stack_.data(),
                         &flood.ended_at_};
  return flood_surface(state, shaft, seed);
}

}  // namespace vcd::baker
