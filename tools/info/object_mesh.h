// The mesh of a sidecar's object, from the sidecar itself or from a mesh file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <vcd/baker/ingest.h>
#include <vcd/baker/prepare.h>
#include <vcd/format/contents.h>
#include <vcd/format/error.h>

namespace vcd::tools {

struct ObjectMesh {
  baker::PreparedMesh mesh;  // with the box of the object's record
  std::string source;        // a clause: where it comes from
  // Of each triangle, as far as the object has horizons: the share of directions above its side that they answer.
  // Negative: the triangle has none. Empty: the object has none.
  std::vector<float> horizons;
};

// All objects' meshes, in their order: from the triangles of the hierarchy, else from embedded geometry, else from the
// mesh file. Reads mesh file and embedded geometry in child processes.
//
// path       of the sidecar, for messages
// mesh_file  may be empty; it is read as it was for the bake, and only if an object needs it
// Errors: usage (a mesh is nowhere, or the file has none of an object's geometry), invalid_file (the triangles in the
// sidecar are not those of its hash, or not in its box), those of load_meshes() and embedded_mesh().
Result<std::vector<ObjectMesh>> meshes_of(const std::string& path, const SidecarContents& sidecar,
                                          const std::string& mesh_file, const baker::IngestOptions& options);

}  // namespace vcd::tools
