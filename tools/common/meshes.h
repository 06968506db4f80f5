// The meshes that a sidecar is held against.
#pragma once

#include <string>
#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/format/contents.h>

namespace vcd {

// All meshes of a file that can be prepared, ingested as the sidecar's provenance says it was baked (null: as by default).
Result<std::vector<PreparedMesh>> load_meshes(const std::string& path, const SidecarContents* sidecar);

// The mesh that is embedded for an object, decoded in a child process. `path` names the sidecar in messages.
Result<PreparedMesh> embedded_mesh(const std::string& path, const ObjectContents& object);

}  // namespace vcd
