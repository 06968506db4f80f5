// The meshes of files, read as their sidecars say, and where they stand.
#pragma once

#include <string>
#include <vector>

#include <vcd/baker/ingest.h>
#include <vcd/format/error.h>

#include "world.h"

namespace vcd::render {

struct FileOptions {
  baker::IngestOptions ingest;        // for meshes that no sidecar has
  std::vector<std::string> sidecars;  // a mesh file is read as the one says that has its meshes
};

struct PlacedParts {
  std::vector<WorldPart> parts;              // each stands somewhere
  std::vector<baker::Placement> placements;  // of the parts
};

// The meshes of one file stand as its nodes say; those of several files stand together as they are. What stands nowhere
// is left out: it needs neither hierarchy nor sidecar. Notes are printed unless quiet. Errors: those of load_meshes();
// unsupported (nothing of it is of a size that can be traced).
Result<PlacedParts> read_parts(const std::vector<std::string>& paths, const FileOptions& options, bool quiet);

}  // namespace vcd::render
