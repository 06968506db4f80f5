// Sidecars and assets of a library find each other by geometry, whatever their names; names only tell what was meant.
#pragma once

#include <memory>
#include <vector>

#include <vcd/verify/library.h>
#include "mesh_source.h"

namespace vcd::verify {

// The mesh is read again when it is asked for. An object without one is stale if an asset has the sidecar's name, else
// orphaned.
std::unique_ptr<MeshSource> against_library(Library& library, const library::FoundFile& file,
                                            const SidecarContents& sidecar);

// One outcome an asset: missing where a mesh's geometry is in none of the sidecars, or unusable, unreadable, not
// verified. is_complete: whether all sidecars were looked at; if not, what is not seen is not verified.
std::vector<Outcome> compare(Library& library, const std::vector<Outcome>& sidecars, bool is_complete);

}  // namespace vcd::verify
