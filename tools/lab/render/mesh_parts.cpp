#include "mesh_parts.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <utility>

#include <vcd/runtime/sidecar.h>

#include "common/describe.h"
#include "common/meshes.h"
#include "common/program.h"

namespace vcd::render {

using namespace baker;
using namespace tools;
namespace {

using GeometryHash = std::array<uint8_t, 16>;

// One way of reading a mesh file, and the sidecars that were made so.
struct Reading {
  IngestOptions options;
  std::vector<GeometryHash> geometries;  // of their objects

  bool is_like(const IngestOptions& other) const {
    return options.treat_all_as_opaque == other.treat_all_as_opaque && options.shift == other.shift &&
           options.subdivide == other.subdivide;
  }
  bool has_any_of(const LoadedMeshes& loaded) const {
    return std::ranges::any_of(loaded.meshes, [&](const PreparedMesh& mesh) {
      return std::ranges::find(geometries, mesh.geometry_hash) != geometries.end();
    });
  }
};

bool names_source(const SidecarContents& sidecar, const std::string& path) {
  return std::ranges::any_of(sidecar.provenance, [&](const auto& pair) {
    return pair.first == "source" && pair.second == std::filesystem::path(path).filename().native();
  });
}

// Those that the sidecars say, each once; first those of sidecars that name the file. What cannot be opened says
// nothing here, and is told where it is used.
std::vector<Reading> readings_of(const std::string& path, const FileOptions& files, bool with_placements) {
  std::vector<Reading> readings;
  for (const bool named : {true, false})
    for (const std::string& name : files.sidecars) {
      const auto sidecar = Sidecar::open(name, {.check = CheckLevel::bounds});
      if (!sidecar || names_source(sidecar->contents(), path) != named) continue;
      IngestOptions options = ingest_options_of(sidecar->contents(), files.ingest);
      options.placements = with_placements;
      auto same = std::ranges::find_if(readings, [&](const Reading& r) { return r.is_like(options); });
      if (same == readings.end()) same = readings.insert(same, {options, {}});
      for (const ObjectContents& object : sidecar->contents().objects)
        same->geometries.push_back(object.record->geometry_hash);
    }
  // The file may hold what came of a subdivision.
  for (size_t i = 0, count = readings.size(); i < count; ++i)
    if (readings[i].options.subdivide > 0) {
      readings.push_back(readings[i]);
      readings.back().options.subdivide = 0;
    }
  return readings;
}

// What the user asks for and the sidecar says otherwise.
void note_difference(const std::string& path, const IngestOptions& wanted, const IngestOptions& taken) {
  if (wanted.treat_all_as_opaque && !taken.treat_all_as_opaque)
    print_note(path + ": read without the parts that are not opaque, as its sidecar was baked");
  if (wanted.shift != std::array<double, 3>{} && wanted.shift != taken.shift)
    print_note(path + ": read with the shift " + shift_text(taken.shift) + ", as its sidecar was baked");
  if (wanted.subdivide > 0 && wanted.subdivide != taken.subdivide)
    print_note(path + ": read with --subdivide " + std::to_string(taken.subdivide) + ", as its sidecar was baked");
}

Result<LoadedMeshes> load_file(const std::string& path, const FileOptions& files, bool with_placements, bool quiet) {
  std::optional<Result<LoadedMeshes>> first;  // tells what is wrong if no sidecar has the meshes
  for (const Reading& reading : readings_of(path, files, with_placements)) {
    auto loaded = load_meshes(path, reading.options);
    const bool is_right = loaded && reading.has_any_of(*loaded);
    if (is_right && !quiet) note_difference(path, files.ingest, reading.options);
    if (is_right) return loaded;
    if (!first) first.emplace(std::move(loaded));
  }
  if (first) return *std::move(first);
  IngestOptions options = files.ingest;
  options.placements = with_placements;
  return load_meshes(path, options);
}

Placement as_it_is(uint64_t mesh, const std::array<double, 3>& shift) {
  return {mesh, {1, 0, 0, shift[0], 0, 1, 0, shift[1], 0, 0, 1, shift[2]}};
}

// Triangles are intersected with products of three lengths, which must be 32-bit floats.
constexpr double kSmallest = 1e-12, kLargest = 1e12;

// Takes over what can be traced; notes what cannot. The last of these, for an error.
std::optional<Error> take_over(const std::string& path, LoadedMeshes&& loaded, PlacedParts& placed,
                               std::vector<std::string>& notes) {
  std::optional<Error> fault;
  std::vector<std::optional<uint64_t>> part_of(loaded.meshes.size());
  for (size_t i = 0; i < loaded.meshes.size(); ++i) {
    PreparedMesh& mesh = loaded.meshes[i];
    const double size = box_of(mesh).diagonal();
    if (size > kSmallest && size < kLargest) {
      part_of[i] = placed.parts.size();
      placed.parts.push_back({.mesh = std::move(mesh), .source = path});
      continue;
    }
    char units[32];
    std::snprintf(units, sizeof units, "%.3g", size);
    fault = Error{ErrorCode::unsupported, path + ": mesh " + std::to_string(mesh.source_index) + " " +
                                              printable(mesh.name) + " cannot be drawn: it is " + units +
                                              " units large, and products of such lengths are no 32-bit floats"};
    loaded.notes.push_back(fault->message.substr(path.size() + 2));
  }
  for (Placement placement : loaded.placements)
    if (const auto part = part_of[placement.mesh]) placed.placements.push_back({*part, placement.transform});
  for (const std::string& note : loaded.notes) notes.push_back(path + ": " + note);
  return fault;
}

// Part i keeps its source.
void drop_unplaced(PlacedParts& placed) {
  std::vector<uint64_t> new_index(placed.parts.size());
  for (const Placement& placement : placed.placements) new_index[placement.mesh] = 1;
  size_t kept = 0;
  for (size_t i = 0; i < new_index.size(); ++i) {
    if (new_index[i] == 0) continue;
    if (kept != i) placed.parts[kept] = std::move(placed.parts[i]);
    new_index[i] = kept++;
  }
  placed.parts.resize(kept);
  for (Placement& placement : placed.placements) placement.mesh = new_index[placement.mesh];
}

}  // namespace

Result<PlacedParts> read_parts(const std::vector<std::string>& paths, const FileOptions& options, bool quiet) {
  PlacedParts placed;
  std::optional<Error> fault;
  std::vector<std::string> notes;
  for (const std::string& path : paths) {
    auto loaded = load_file(path, options, paths.size() == 1, quiet);
    if (!loaded) return loaded.error();
    if (auto undrawn = take_over(path, std::move(*loaded), placed, notes)) fault = std::move(undrawn);
  }
  if (placed.parts.empty()) return *std::move(fault);
  for (const std::string& note : notes)
    if (!quiet) print_note(note);
  if (placed.placements.empty())
    for (size_t i = 0; i < placed.parts.size(); ++i)
      placed.placements.push_back(as_it_is(i, placed.parts[i].mesh.shift));
  drop_unplaced(placed);
  return placed;
}

}  // namespace vcd::render
