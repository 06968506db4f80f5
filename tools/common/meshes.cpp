#include "meshes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <vcd/baker/bake.h>
#include <vcd/baker/ingest.h>

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

std::optional<Error> each_mesh(const std::string& path, const IngestOptions& options, const TakeMesh& take) {
  auto ingested = ingest_isolated(path, options);
  if (!ingested) return ingested.error();
  for (SourceMesh& source : ingested->meshes) {
    const std::string name = source.name;
    const uint32_t index = source.source_index;
    take(name, index, prepare(std::move(source)));
  }
  return std::nullopt;
}

IngestOptions ingest_options_of(const SidecarContents& sidecar, IngestOptions options) {
  options.coarse = true;  // whether to bake it was decided when it was baked
  for (const auto& [key, value] : sidecar.provenance) {
    if (key == "parts") options.treat_all_as_opaque = value != "opaque";
    if (key == "shift") options.shift = parse_shift(value).value_or(options.shift);
  }
  return options;
}

Result<std::vector<PreparedMesh>> load_meshes(const std::string& path, const IngestOptions& options) {
  std::vector<PreparedMesh> meshes;
  Error last;
  const auto fault = each_mesh(path, options, [&](const std::string&, uint32_t, Result<PreparedMesh>&& mesh) {
    if (mesh) return meshes.push_back(std::move(*mesh));
    last = Error{mesh.error().code, path + ": " + mesh.error().message};
  });
  if (fault) return *fault;
  if (meshes.empty()) return last;
  return meshes;
}

Result<PreparedMesh> embedded_mesh(const std::string& path, const ObjectContents& object) {
  auto source = decode_geometry_isolated(object.geometry, path + ": embedded geometry");
  if (!source) return source.error();
  auto mesh = prepare(std::move(*source));
  if (!mesh) return Error{ErrorCode::invalid_file, path + ": embedded geometry: " + mesh.error().message};
  return mesh;
}

}  // namespace vcd::tools
