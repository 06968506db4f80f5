#include "ingest/soup.h"

#include <limits>
#include <span>

#include "ingest/check.h"
#include "ingest/polygon.h"
#include "ingest/text.h"

namespace vcd {
namespace {

// How many faces something happened to, and which was the first.
struct Tally {
  size_t count = 0;
  size_t first = 0;

  void add(size_t face) {
    if (count++ == 0) first = face;
  }
  std::string faces() const {
    return counted(count, "face") + " (the first is number " + std::to_string(first) + ", counted from 0)";
  }
};

std::string no_triangle(const PolygonSoup& soup) {
  return "holds " + counted(soup.positions.size(), "point") + " and no triangle" +
         (soup.face_ends.empty()
              ? ""
              : " (" + counted(soup.face_ends.size(), "face") + " with fewer than three distinct corners)");
}

}  // namespace

Result<Ingested> mesh_from_soup(const std::filesystem::path& path, PolygonSoup soup) {
  if (soup.positions.size() >= std::numeric_limits<uint32_t>::max()) {
    return file_error(path, ErrorCode::unsupported, "more vertices than 32-bit indices can name");
  }
  SourceMesh mesh;
  mesh.name = path.stem().string();
  mesh.triangles.reserve(soup.face_ends.size());
  Tally degenerate;
  Tally forced;
  size_t begin = 0;
  for (size_t face = 0; face < soup.face_ends.size(); ++face) {
    const std::span<const uint32_t> corners(soup.corners.data() + begin, soup.face_ends[face] - begin);
    begin = soup.face_ends[face];
    const PolygonCut cut = append_polygon(soup.positions, corners, mesh.triangles);
    if (cut == PolygonCut::degenerate) degenerate.add(face);
    if (cut == PolygonCut::forced) forced.add(face);
  }
  if (mesh.triangles.empty()) return file_error(path, ErrorCode::invalid_file, no_triangle(soup));

  if (degenerate.count > 0) {
    soup.notes.push_back(degenerate.faces() + " with fewer than three distinct corners passed over");
  }
  if (forced.count > 0) {
    soup.notes.push_back("no clean way to cut " + forced.faces() + " into triangles: the outline crosses itself");
  }
  mesh.positions = std::move(soup.positions);
  Ingested ingested;
  for (const std::string& note : soup.notes) {
    ingested.notes.push_back("mesh \"" + mesh.name + "\": " + note);
  }
  ingested.meshes.push_back(std::move(mesh));
  return ingested;
}

}  // namespace vcd
