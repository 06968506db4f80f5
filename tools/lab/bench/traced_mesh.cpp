#include "traced_mesh.h"

#include "common/meshes.h"
#include "common/program.h"

namespace vcd::bench {

using namespace baker;
using namespace tools;

Result<TracedMesh> TracedMesh::load(const MeshToRead& file, const std::array<uint8_t, 16>* hash) {
  auto loaded = load_meshes(file.path, file.ingest);
  if (!loaded) return loaded.error();
  for (const std::string& note : loaded->notes)
    if (!file.quiet) print_note(file.path + ": " + note);
  for (PreparedMesh& mesh : loaded->meshes) {
    if (hash && mesh.geometry_hash != *hash) continue;
    auto tracer = Tracer::build(mesh.positions, mesh.triangles, TraceMode::fast);
    if (!tracer) return tracer.error();
    return TracedMesh{std::move(mesh), std::move(*tracer)};
  }
  return Error{ErrorCode::stale, file.path + ": none of its meshes has the sidecar's geometry hash"};
}

}  // namespace vcd::bench
