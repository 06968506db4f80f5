// Whether a segment meets a mesh, decided exactly: the last word over Embree and over a sidecar.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/format/segment.h>

namespace vcd::baker {

// Floats are dyadic rationals, so segment and triangles are exact data, and "some point of the segment is a point of a
// triangle" has one answer; this gives it. Triangles are closed, segments are open (spec/conventions.md, 1 to 4 and
// 20):
//   - a line through an edge or a vertex meets the triangle, and so does one in its plane that overlaps it;
//   - a triangle that only touches t_min or t_max is not met;
//   - a direction of zero length is the point `origin`;
//   - a NaN in the interval, or t_min >= t_max, is never met; nor is a NaN or an infinity in origin or direction.
//
// A hierarchy of boxes and then a test of each triangle, both in doubles with derived error bounds; what they leave in
// doubt is decided in integers of any length. Sources: audit/segment_triangle.cpp.
class Referee {
 public:
  // Copies the triangles (72 bytes each, about). Their time to build is that of sorting them.
  explicit Referee(const PreparedMesh& mesh);

  // The segment is in the object's own frame, as the mesh. Safe from any thread.
  bool occluded(const Segment& segment) const;

  // The same for an array, on all cores: blocked[i] is 1 or 0 for segments[i]; as many as segments.
  void occluded(std::span<const Segment> segments, std::span<uint8_t> blocked) const;

 private:
  using Triangle = std::array<Position, 3>;
  struct Box {
    Position min, max;
  };
  struct Query;
  void build(size_t node, size_t begin, size_t end);
  bool search(Query& query, size_t node, size_t begin, size_t end) const;

  // A complete binary tree: the children of node n are 2 n + 1 and 2 n + 2, and hold the halves of its triangles.
  std::vector<Box> boxes_;
  std::vector<Triangle> triangles_;
};

}  // namespace vcd::baker
