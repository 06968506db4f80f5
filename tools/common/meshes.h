// The meshes that a sidecar is held against.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/format/contents.h>

namespace vcd {

// Gets a mesh, or why this one cannot be prepared.
using TakeMesh = std::function<void(const std::string& name, uint32_t source_index, Result<baker::PreparedMesh>&&)>;

// Ingests a file in a child process and prepares its meshes one after another. The error of a file that cannot be
// ingested.
std::optional<Error> each_mesh(const std::string& path, bool all_as_opaque, const TakeMesh& take);

// Whether the sidecar's provenance says that parts were baked as opaque that are not.
bool baked_all_as_opaque(const SidecarContents& sidecar);

// All meshes of a file that can be prepared, ingested as the sidecar's provenance says it was baked (null: as by
// default).
Result<std::vector<baker::PreparedMesh>> load_meshes(const std::string& path, const SidecarContents* sidecar);

// The mesh that is embedded for an object, decoded in a child process. `path` names the sidecar in messages.
Result<baker::PreparedMesh> embedded_mesh(const std::string& path, const ObjectContents& object);

}  // namespace vcd
