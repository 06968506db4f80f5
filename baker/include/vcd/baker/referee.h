// Whether a segment meets a mesh, decided exactly: the last word over Embree and over a sidecar.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/format/meets.h>
#include <vcd/format/segment.h>

namespace vcd {
class WideRay;  // <vcd/format/wide_ray.h>
}

namespace vcd::baker {

// Asks meets() (<vcd/format/meets.h>) of every triangle whose box the segment could meet.
class Referee {
 public:
  // Copies the triangles (72 bytes each, about). Their time to build is that of sorting them.
  explicit Referee(const PreparedMesh& mesh);

  // The segment is in the object's own frame, as the mesh. Safe from any thread.
  bool occluded(const Segment& segment) const;

  // The same for an array, on all cores: blocked[i] is 1 or 0 for segments[i]; as many as segments.
  void occluded(std::span<const Segment> segments, std::span<uint8_t> blocked) const;

 private:
  struct Box {
    Position min, max;
  };
  void build(size_t node, size_t begin, size_t end);
  bool search(const Segment& segment, const WideRay& ray, size_t node, size_t begin, size_t end) const;

  // A complete binary tree: the children of node n are 2 n + 1 and 2 n + 2, and hold the halves of its triangles.
  std::vector<Box> boxes_;
  std::vector<Triangle> triangles_;
};

}  // namespace vcd::baker
