// A mesh file as vc-info shows it: what vc-bake would make of it, and what of it is no closed surface.
#pragma once

#include <string>

#include <vcd/baker/ingest.h>
#include <vcd/format/error.h>

#include "common/describe.h"

namespace vcd::tools {

struct ShownMesh {
  std::string text;  // several lines
  Json json;
  std::string culprits;  // an OBJ file of its boundary and non-manifold edges
};

// Notes go to standard error unless quiet. Errors: those of MeshFile::read() and MeshFile::fault().
Result<ShownMesh> show_mesh(const std::string& path, const baker::IngestOptions& options, bool quiet);

}  // namespace vcd::tools
