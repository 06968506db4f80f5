#include "meshes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <vcd/baker/bake.h>

#include "describe.h"

namespace vcd::tools {

using namespace baker;

std::string shift_text(const std::array<double, 3>& shift) {
  std::string text;
  for (const double number : shift) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, number).ptr;
    text += (text.empty() ? "" : ",") + std::string(digits, end);
  }
  return text;
}

std::optional<std::array<double, 3>> parse_shift(std::string_view text) {
  std::array<double, 3> shift;
  for (size_t axis = 0; axis < 3; ++axis) {
    const std::string_view word = text.substr(0, axis < 2 ? text.find(',') : text.size());
    const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), shift[axis]);
    if (fault != std::errc() || end != word.data() + word.size() || !std::isfinite(shift[axis])) return std::nullopt;
    text.remove_prefix(std::min(text.size(), word.size() + 1));
  }
  return shift;
}

IngestOptions ingest_options_of(const SidecarContents& sidecar, IngestOptions options) {
  options.coarse = true;  // whether to bake it was decided when it was baked
  options.subdivide = 0;
  for (const auto& [key, value] : sidecar.provenance) {
    if (key == "parts") options.treat_all_as_opaque = value != "opaque";
    if (key == "subdivide") std::from_chars(value.data(), value.data() + value.size(), options.subdivide);
  }
  if (!sidecar.objects.empty()) std::ranges::copy(sidecar.objects[0].record->shift, options.shift.begin());
  return options;
}

Result<MeshFile> MeshFile::read(const std::filesystem::path& path, const IngestOptions& options,
                                const IngestLimits& limits) {
  auto ingested = ingest_isolated(path, options, limits);
  if (!ingested) return ingested.error();
  return MeshFile(path, std::move(*ingested));
}

std::optional<PreparedMesh> MeshFile::next() {
  while (next_ < ingested_.meshes.size()) {
    SourceMesh& source = ingested_.meshes[next_];
    const std::string place = "mesh " + std::to_string(source.source_index) + " " + printable(source.name);
    auto mesh = prepare(std::move(source));
    if (mesh) {
      given_.push_back(static_cast<uint32_t>(next_++));
      return std::move(*mesh);
    }
    ++next_;
    ingested_.notes.push_back(mesh.error().message + "; left out");
    unusable_.push_back({place, mesh.error()});
  }
  return std::nullopt;
}

std::optional<Error> MeshFile::fault() const {
  if (!given_.empty() || unusable_.empty()) return std::nullopt;
  const Error& last = unusable_.back().error;
  return Error{last.code, path_.string() + ": " + last.message};
}

std::vector<Placement> MeshFile::placements() const {
  std::vector<Placement> placements;
  for (Placement placement : ingested_.placements) {
    const auto found = std::ranges::lower_bound(given_, placement.mesh);
    if (found == given_.end() || *found != placement.mesh) continue;
    placement.mesh = static_cast<uint32_t>(found - given_.begin());
    placements.push_back(placement);
  }
  return placements;
}

Result<LoadedMeshes> load_meshes(const std::filesystem::path& path, const IngestOptions& options) {
  auto file = MeshFile::read(path, options);
  if (!file) return file.error();
  LoadedMeshes loaded;
  while (auto mesh = file->next()) loaded.meshes.push_back(std::move(*mesh));
  if (auto fault = file->fault()) return *std::move(fault);
  loaded.placements = file->placements();
  loaded.notes = file->notes();
  return loaded;
}

Result<PreparedMesh> embedded_mesh(const std::string& path, const ObjectContents& object) {
  auto source = decode_geometry_isolated(object.geometry, path + ": embedded geometry");
  if (!source) return source.error();
  auto mesh = prepare(std::move(*source));
  if (!mesh) return Error{ErrorCode::invalid_file, path + ": embedded geometry: " + mesh.error().message};
  return mesh;
}

}  // namespace vcd::tools
