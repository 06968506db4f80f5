// Which sidecar is of which mesh.
#pragma once

#include <cstddef>
#include <optional>

#include <vcd/runtime/sidecar.h>

#include "mesh.h"

namespace vcd::preload {

// Reads the mesh's buffers and finds its sidecar; exports the mesh if it has none. None: there is no sidecar, or none
// that can be asked here. Meshes that were seen before are known by their fingerprints. Safe from any thread; throws
// nothing but std::bad_alloc.
std::optional<Object> sidecar_of(const Mesh& mesh);

struct MeshCounts {
  size_t meshes = 0, with_sidecar = 0, exported = 0;  // different ones
};
MeshCounts mesh_counts();

}  // namespace vcd::preload
