#include <vcd/baker/ingest.h>

#include <algorithm>
#include <cctype>
#include <new>
#include <string>

#include "ingest/check.h"
#include "ingest/draco_mesh.h"
#include "ingest/gltf.h"
#include "ingest/gltf_nodes.h"
#include "ingest/obj.h"
#include "ingest/off.h"
#include "ingest/ply.h"
#include "ingest/stl.h"
#include "ingest/subdivide.h"
#include "ingest/what_else.h"

namespace vcd::baker {
namespace {

// The path is for messages, and for what the bytes name relative to it.
using Reader = Result<Ingested> (*)(const std::filesystem::path&, std::string_view bytes, const IngestOptions&);

struct Format {
  const char* extension;
  Reader read;
};

constexpr Format kFormats[] = {
    {".glb", ingest_gltf}, {".gltf", ingest_gltf}, {".drc", ingest_drc}, {".obj", ingest_obj},
    {".ply", ingest_ply},  {".stl", ingest_stl},   {".off", ingest_off},
};

Reader reader_for(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const Format& format : kFormats) {
    if (extension == format.extension) return format.read;
  }
  return nullptr;
}

std::string known_extensions() {
  std::string list;
  for (const Format& format : kFormats) list += (list.empty() ? "" : ", ") + std::string(format.extension);
  return list;
}

// A binary STL file may begin with anything; its size tells it.
bool is_binary_stl(const std::filesystem::path& path, std::string_view bytes) {
  return reader_for(path) == ingest_stl && size_fits_binary_stl(bytes);
}

constexpr std::array<double, 3> kNoShift{};

// Coordinates that are floats already: subtracted from in double, rounded once.
void shift_floats(Ingested& ingested, const std::array<double, 3>& shift) {
  for (SourceMesh& mesh : ingested.meshes) {
    mesh.shift = shift;
    for (Position& position : mesh.positions)
      for (size_t axis = 0; axis < 3; ++axis) position[axis] = static_cast<float>(position[axis] - shift[axis]);
  }
}

void take_shift_back(Ingested& ingested, const std::array<double, 3>& shift) {
  for (Placement& placement : ingested.placements)
    for (size_t row = 0; row < 12; row += 4)
      for (size_t axis = 0; axis < 3; ++axis)
        placement.transform[row + 3] += placement.transform[row + axis] * shift[axis];
  const auto lost = std::erase_if(ingested.placements, [](const Placement& placement) {
    return why_not_invertible(placement.transform) != nullptr;
  });
  if (lost > 0) ingested.notes.push_back("the shift takes " + std::to_string(lost) + " placed meshes out of sight");
}

}  // namespace

std::vector<std::string> mesh_extensions() {
  std::vector<std::string> extensions;
  for (const Format& format : kFormats) extensions.emplace_back(format.extension + 1);
  return extensions;
}

Result<Ingested> ingest(const std::filesystem::path& path, const IngestOptions& options) try {
  const Reader read = reader_for(path);
  if (read == nullptr) {
    return file_error(path, ErrorCode::unsupported,
                      "unknown extension \"" + path.extension().string() + "\" (known: " + known_extensions() + ")");
  }
  const Result<std::string> bytes = read_file(path);
  if (!bytes) return bytes.error();
  if (const char* what = what_else(*bytes); what && !is_binary_stl(path, *bytes))
    return file_error(path, ErrorCode::invalid_file, what);
  Result<Ingested> result = read(path, *bytes, options);
  if (!result) return result;
  if (options.shift != kNoShift && (read == ingest_gltf || read == ingest_drc)) shift_floats(*result, options.shift);
  result->sources.insert(result->sources.begin(), {path.filename().string(), content_hash(*bytes)});
  if (options.placements && read != ingest_gltf) {
    for (uint32_t i = 0; i < result->meshes.size(); ++i) result->placements.push_back({.mesh = i});
  }
  if (options.shift != kNoShift) take_shift_back(*result, options.shift);
  if (std::optional<Error> fault = check_ingested(path, *result)) return *std::move(fault);
  if (options.subdivide > 0)
    if (std::optional<Error> fault = subdivide(path, options.subdivide, *result)) return *std::move(fault);
  return result;
} catch (const std::bad_alloc&) {
  return file_error(path, ErrorCode::runtime, "out of memory while reading");
} catch (const std::exception& error) {
  // std::length_error and the like: a library stumbled over the file.
  return file_error(path, ErrorCode::runtime, std::string("the parser failed: ") + error.what());
}

}  // namespace vcd::baker
