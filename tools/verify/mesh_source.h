// Where the meshes come from that one sidecar's objects are held against.
#pragma once

#include <memory>
#include <span>
#include <string>

#include <vcd/baker/ingest.h>
#include <vcd/baker/prepare.h>
#include <vcd/format/contents.h>

#include <vcd/verify/outcome.h>

namespace vcd::verify {

class MeshSource {
 public:
  virtual ~MeshSource() = default;

  // The mesh with the object's geometry hash; valid until the next call. Null if there is none: then the outcome says
  // why. place: the object, for messages.
  virtual const baker::PreparedMesh* mesh_of(const ObjectContents& object, const std::string& place,
                                             Outcome& outcome) = 0;
};

// One mesh file, read when it is first asked for.
std::unique_ptr<MeshSource> against_file(const std::string& path, const baker::IngestOptions& options);

// Meshes in memory, which outlive the source.
std::unique_ptr<MeshSource> against_meshes(std::span<const baker::PreparedMesh> meshes);

// Thrown where work ends early because the user wants it to.
struct Interrupted {};

}  // namespace vcd::verify
