#include "ingest/check.h"

#include <cmath>

namespace vcd::baker {
namespace {

// What is wrong with one mesh; empty if nothing is.
std::string fault_of(const SourceMesh& mesh) {
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const Position& p = mesh.positions[i];
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
      return "position " + std::to_string(i) + " is not finite";
    }
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const uint32_t index : mesh.triangles[i]) {
      if (index >= mesh.positions.size()) {
        return "triangle " + std::to_string(i) + ": index " + std::to_string(index) + " is out of range (" +
               std::to_string(mesh.positions.size()) + " positions)";
      }
    }
  }
  return mesh.triangles.empty() ? "holds no triangle" : "";
}

}  // namespace

Error file_error(const std::filesystem::path& path, ErrorCode code, const std::string& reason) {
  return Error{code, path.string() + ": " + reason};
}

std::optional<Error> check_ingested(const std::filesystem::path& path, const Ingested& ingested) {
  if (ingested.meshes.empty()) return file_error(path, ErrorCode::invalid_file, "holds no mesh");
  for (const SourceMesh& mesh : ingested.meshes) {
    const std::string fault = fault_of(mesh);
    if (fault.empty()) continue;
    return file_error(path, ErrorCode::invalid_file,
                      "mesh " + std::to_string(mesh.source_index) + " \"" + mesh.name + "\": " + fault);
  }
  return std::nullopt;
}

}  // namespace vcd::baker
