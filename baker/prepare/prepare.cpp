#include <vcd/baker/prepare.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <vcd/format/line_cell.h>

#include "box.h"
#include "geometry_hash.h"
#include "place.h"
#include "weld.h"

namespace vcd::baker {

namespace {

bool is_sound(const SourceMesh& source) {
  const auto finite = [](const Position& p) {
    return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
  };
  const auto inside = [&](const TriangleIndices& t) { return std::ranges::max(t) < source.positions.size(); };
  return std::ranges::all_of(source.positions, finite) && std::ranges::all_of(source.triangles, inside);
}

}  // namespace

Result<PreparedMesh> prepare(SourceMesh&& source) {
  if (!is_sound(source))
    return Error{ErrorCode::usage, "mesh \"" + source.name + "\": a position is not finite, or an index is too large"};
  PreparedMesh mesh;
  mesh.name = std::move(source.name);
  mesh.source_index = source.source_index;
  mesh.shift = source.shift;
  mesh.left_out = source.left_out;
  weld(std::move(source), mesh);
  if (mesh.triangles.empty())
    return Error{ErrorCode::invalid_file, place_of(mesh) + ": no triangle with an area (" +
                                              std::to_string(mesh.zero_area_triangles) + " have none)"};
  if (!pad_box(mesh))
    return Error{ErrorCode::unsupported, place_of(mesh) + ": its box is too large or too small for 32-bit floats"};
  mesh.geometry_hash = geometry_hash(mesh);
  return mesh;
}

std::vector<Position> positions_in_grid(const PreparedMesh& mesh) {
  const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
  std::vector<Position> positions = mesh.positions;
  for (Position& p : positions)
    for (int a = 0; a < 3; ++a) p[a] = to_grid(frame, a, p[a]);
  return positions;
}

}  // namespace vcd::baker
