// A sheet: the part of a surface that can be reached inside a shaft, and whether it blocks every line of it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <vcd/baker/mesh.h>

#include "classify/kernels.h"
#include "classify/shaft.h"

namespace vcd::baker {

class Surface {
 public:
  // positions and triangles are referred to and outlive this. neighbour: pair_edges() of the triangles.
  Surface(std::span<const Position> positions, std::span<const TriangleIndices> triangles,
          std::vector<uint32_t> neighbour);

  // One thread's memory of what a flood has reached.
  class Flood {
   public:
    // Forgets what earlier floods have reached. For each shaft, before its first flood.
    void begin(size_t triangles);
    bool reached(uint32_t triangle) const { return stamps_[triangle] == stamp_; }         // by the last flood
    bool reached_before(uint32_t triangle) const { return stamps_[triangle] >= first_; }  // by any since begin()
    // Where a flood since begin() came to a boundary edge: 3 · triangle + edge. kBoundary if none did.
    uint32_t ended_at() const { return ended_at_; }

   private:
    friend class Surface;
    std::vector<uint32_t> stamps_;  // by triangle
    uint32_t first_ = 1, stamp_ = 0, ended_at_ = 0;
    std::vector<FloodStep> stack_;
  };

  const Position& corner(uint32_t triangle, uint32_t c) const { return vertices_[triangles_[triangle][c]]; }
  // Across the edge from corner `edge` to the next; kBoundary where there is none.
  uint32_t neighbour(uint32_t triangle, uint32_t edge) const { return neighbour_[3 * size_t{triangle} + edge]; }

  // Spreads from a triangle that was not reached before through every edge that meets the shaft. True if it ends at no
  // boundary edge that meets the shaft and within `limit` triangles: then each segment between the shaft's two squares
  // crosses the triangles reached an even number of times, or each an odd number (intersection numbers modulo 2:
  // Guillemin and Pollack 1974, 2.4; as a test for occluders: Navazo et al. 2003). A flood that comes to what a failed
  // one has reached fails too.
  bool flood(const Shaft& shaft, uint32_t seed, uint32_t limit, Flood& flood) const;

 private:
  std::span<const Position> vertices_;
  std::span<const TriangleIndices> triangles_;
  std::vector<uint32_t> neighbour_;
};

}  // namespace vcd::baker
