// Mesh files with their sidecar attached: spec/attached.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <vcd/format/bytes.h>
#include <vcd/format/error.h>
#include <vcd/format/geometry_hash.h>

namespace vcd::baker {

struct Attachment {
  struct Mesh {
    uint32_t source_index;  // of the glTF mesh; 0 for formats with one mesh a file
    GeometryHash geometry_hash;
  };

  std::string uri = {};  // of the sidecar, relative to the mesh file and percent-encoded
  Bytes embedded = {};   // or its bytes, to be stored in the mesh file (glTF only); then there is no uri
  std::vector<Mesh> meshes;
};

// The mesh file's bytes with the attachment: the extension VCD_visibility of glTF meshes, a comment in PLY and OBJ. No
// other byte changes, but for lengths that say how long the rest is and for padding; in GLB, what lies behind the
// declared length is dropped.
//
// path: names the format, and the file in messages. Errors: usage (this format cannot hold it, or the file has one
// already), invalid_file (what ingest() would refuse of JSON and container, too), unsupported (GLB beyond 4 GiB).
// Safe from any thread.
Result<std::string> attach(const std::filesystem::path& path, std::string_view bytes, const Attachment& attachment);

// Whether the bytes look as if attach() had written them.
bool is_attached(std::string_view bytes);

}  // namespace vcd::baker
