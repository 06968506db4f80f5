// An object's surface as the page draws it, and what its sidecar says of the lines through each place of it.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/baker/why_unclassified.h>
#include <vcd/format/contents.h>
#include <vcd/format/error.h>

namespace vcd::tools {

// Triangles to draw. Each stands for a place of the mesh's surface: the middle of itself if it is whole or part of a
// triangle of the mesh, else the middle of a triangle of the mesh that has its first corner.
struct DrawnSurface {
  std::vector<baker::Position> positions;
  std::vector<baker::TriangleIndices> triangles;
  std::vector<uint32_t> source;  // of each, the triangle of the mesh
  bool thinned = false;          // the mesh has more triangles than may be drawn
};

// At most so many triangles, 1 or more. Of a mesh of few, each is cut into equal ones, so that colours can vary.
// Depends on the mesh and the number only.
DrawnSurface drawn_surface(const baker::PreparedMesh& mesh, size_t most_triangles);

// Of each drawn triangle, of the lines through its place in kDirections directions that are spread evenly; shares are
// 0 to 255.
struct SurfaceShares {
  std::vector<uint8_t> answered, proven;  // of all; lines through the surface are blocked, if nothing is wrong
  // Of those that are unclassified, or a few of them: all 0 where none is.
  std::array<std::vector<uint8_t>, baker::kWhys> why;
};
inline constexpr size_t kDirections = 48;

// Errors: those of why_unclassified().
Result<SurfaceShares> surface_shares(const ObjectContents& object, const baker::PreparedMesh& mesh,
                                     const DrawnSurface& surface, const std::function<bool()>& stop);

}  // namespace vcd::tools
