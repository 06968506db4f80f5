#include "traced_mesh.h"

#include "common/meshes.h"

namespace vcd::bench {

using namespace baker;
using namespace tools;

Result<TracedMesh> TracedMesh::load(const std::string& path, const IngestOptions& options,
                                    const std::array<uint8_t, 16>* hash) {
  auto meshes = load_meshes(path, options);
  if (!meshes) return meshes.error();
  for (PreparedMesh& mesh : *meshes) {
    if (hash && mesh.geometry_hash != *hash) continue;
    auto tracer = Tracer::build(mesh.positions, mesh.triangles, TraceMode::fast);
    if (!tracer) return tracer.error();
    return TracedMesh{std::move(mesh), std::move(*tracer)};
  }
  return Error{ErrorCode::stale, path + ": none of its meshes has the sidecar's geometry hash"};
}

}  // namespace vcd::bench
