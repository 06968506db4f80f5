#include <vcd/baker/prepare.h>

#include <utility>

#include <vcd/format/geometry_hash.h>
#include <vcd/format/line_cell.h>

#include "box.h"
#include "place.h"

namespace vcd::baker {

Result<PreparedMesh> prepare(SourceMesh&& source) {
  if (!is_sound(source.positions, source.triangles))
    return Error{ErrorCode::usage, "mesh \"" + source.name + "\": a position is not finite, or an index is too large"};
  PreparedMesh mesh;
  mesh.name = std::move(source.name);
  mesh.source_index = source.source_index;
  mesh.shift = source.shift;
  mesh.left_out = source.left_out;
  WeldedMesh welded = weld(std::move(source.positions), std::move(source.triangles));
  mesh.duplicate_triangles = welded.duplicate_triangles;
  mesh.zero_area_triangles = welded.zero_area_triangles;
  if (welded.triangles.empty())
    return Error{ErrorCode::invalid_file, place_of(mesh) + ": no triangle with an area (" +
                                              std::to_string(mesh.zero_area_triangles) + " have none)"};
  mesh.geometry_hash = geometry_hash(welded);
  mesh.positions = std::move(welded.positions);
  mesh.triangles = std::move(welded.triangles);
  mesh.source_triangles = std::move(welded.source_triangles);
  if (!pad_box(mesh))
    return Error{ErrorCode::unsupported, place_of(mesh) + ": its box is too large or too small for 32-bit floats"};
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
