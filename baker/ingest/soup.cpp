#include "ingest/soup.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <span>

#include "ingest/check.h"
#include "ingest/polygon.h"
#include "ingest/text.h"

namespace vcd::baker {
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

// How well floats hold the positions that faces use.
struct Rounding {
  double most = 0;    // units
  double extent = 0;  // the longest side of the box
  std::array<double, 3> center{};
};

Rounding rounding_of(const PolygonSoup& soup) {
  Rounding rounding;
  Position low, high;
  low.fill(std::numeric_limits<float>::infinity()), high.fill(-std::numeric_limits<float>::infinity());
  for (const uint32_t corner : soup.corners) {
    if (corner >= soup.positions.size()) continue;  // check_ingested() says so
    const Position& p = soup.positions[corner];
    for (size_t axis = 0; axis < 3; ++axis)
      low[axis] = std::min(low[axis], p[axis]), high[axis] = std::max(high[axis], p[axis]);
    if (!soup.roundings.empty()) rounding.most = std::max<double>(rounding.most, soup.roundings[corner]);
  }
  for (size_t axis = 0; axis < 3; ++axis) {
    rounding.extent = std::max(rounding.extent, double{high[axis]} - low[axis]);
    rounding.center[axis] = std::round((double{low[axis]} + high[axis]) / 2 + soup.shift[axis]);
  }
  return rounding;
}

std::string shown(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", number);
  return text;
}

std::string describe(const Rounding& r) {
  return "its coordinates are so large that 32-bit floats move them by up to " + shown(r.most) + ", at an extent of " +
         shown(r.extent) + "; --shift " + shown(r.center[0]) + "," + shown(r.center[1]) + "," + shown(r.center[2]) +
         " keeps its shape";
}

}  // namespace

void PolygonSoup::add_position(const Coordinates& given) {
  Position position;
  double most = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double moved = given[axis].value - shift[axis];
    position[axis] = shift[axis] == 0 ? given[axis].nearest : static_cast<float>(moved);
    most = std::max(most, std::fabs(moved - position[axis]));
  }
  if (most > 0 || !roundings.empty()) {
    roundings.resize(positions.size());
    roundings.push_back(static_cast<float>(most));
  }
  positions.push_back(position);
}

Result<Ingested> mesh_from_soup(const std::filesystem::path& path, PolygonSoup soup, const IngestOptions& options) {
  if (soup.positions.size() >= std::numeric_limits<uint32_t>::max()) {
    return file_error(path, ErrorCode::unsupported, "more vertices than 32-bit indices can name");
  }
  SourceMesh mesh;
  mesh.name = path.stem().string();
  mesh.triangles.reserve(soup.face_ends.size());
  Tally degenerate;
  Tally forced;
  Tally bent;
  size_t begin = 0;
  for (size_t face = 0; face < soup.face_ends.size(); ++face) {
    const std::span<const uint32_t> corners(soup.corners.data() + begin, soup.face_ends[face] - begin);
    begin = soup.face_ends[face];
    const PolygonCut cut = append_polygon(soup.positions, corners, mesh.triangles);
    if (cut == PolygonCut::degenerate) degenerate.add(face);
    if (cut == PolygonCut::forced) forced.add(face);
    if (cut != PolygonCut::degenerate && corners.size() > 3 && !is_plane(soup.positions, corners)) bent.add(face);
  }
  if (mesh.triangles.empty()) return file_error(path, ErrorCode::invalid_file, no_triangle(soup));

  if (degenerate.count > 0) {
    soup.notes.push_back(degenerate.faces() + " with fewer than three distinct corners passed over");
  }
  if (forced.count > 0) {
    soup.notes.push_back("no clean way to cut " + forced.faces() + " into triangles: the outline crosses itself");
  }
  if (bent.count > 0) {
    soup.notes.push_back(bent.faces() + " of " + std::to_string(soup.face_ends.size()) +
                         " not plane: cut as spec/conventions.md says, and a renderer that cuts them otherwise has "
                         "another surface");
  }
  constexpr double kNoted = 0x1p-16, kRefused = 0x1p-10;
  const Rounding rounding = rounding_of(soup);
  if (rounding.most > kRefused * rounding.extent && !options.coarse)
    return file_error(path, ErrorCode::unsupported, describe(rounding) + " (--allow-rounding bakes it as it is)");
  if (rounding.most > kNoted * rounding.extent) soup.notes.push_back(describe(rounding));
  mesh.positions = std::move(soup.positions);
  mesh.shift = soup.shift;
  Ingested ingested;
  for (const std::string& note : soup.notes) {
    ingested.notes.push_back("mesh \"" + mesh.name + "\": " + note);
  }
  ingested.meshes.push_back(std::move(mesh));
  return ingested;
}

}  // namespace vcd::baker
