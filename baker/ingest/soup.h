// What the readers of OBJ, PLY, STL and OFF gather, and how it becomes a mesh.
#pragma once

#include <vcd/baker/ingest.h>
#include <vcd/baker/mesh.h>
#include <vcd/format/error.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/text.h"

namespace vcd::baker {

// Polygons as a file states them.
struct PolygonSoup {
  std::array<double, 3> shift{};  // subtracted from every coordinate before it is rounded to a float
  std::vector<Position> positions;
  std::vector<float> roundings;    // how far each position lies from what the file says; empty while all are exact
  std::vector<uint32_t> corners;   // indices into positions, face after face
  std::vector<size_t> face_ends;   // for each face, the end of its corners
  std::vector<std::string> notes;  // what the reader passed over: sentences without the name of the mesh

  void add_position(const Coordinates& given);

  // Closes a face: all corners since the last one belong to it, be they none.
  void end_face() { face_ends.push_back(corners.size()); }
};

// One mesh, named like the file without folder and extension, from polygons whose corners are all in range
// (not checked here; check_ingested does). Polygons are cut as polygon.h says; what is passed over gets a note, and
// so do polygons that are not plane, and coordinates that floats hold badly. Errors: invalid_file if no triangle comes
// of it; unsupported beyond 2^32 - 1 positions, and where rounding spoils the shape (IngestOptions::coarse allows it).
Result<Ingested> mesh_from_soup(const std::filesystem::path& path, PolygonSoup soup, const IngestOptions& options);

}  // namespace vcd::baker
