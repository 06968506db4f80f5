// A sidecar as one HTML file to look at, which loads nothing else: each object in 3-D by what its look-ups answer, the
// cell of the line under the cursor, its classes from eight directions, and what vc-info prints of it.
#pragma once

#include <functional>
#include <string>

#include <vcd/baker/ingest.h>
#include <vcd/format/contents.h>
#include <vcd/format/error.h>

namespace vcd::tools {

struct PageOptions {
  std::string mesh_file;        // of objects whose triangles the sidecar does not hold; may be empty
  baker::IngestOptions ingest;  // of what no sidecar says: files_outside
  std::function<bool()> stop;   // asked often; true ends it with an error
};

// What a page holds at most. Meshes of more triangles together are thinned, the large ones most; trees beyond are left
// out in the order of the objects, and there is no look-up under the cursor then. The page says so.
inline constexpr size_t kMostDrawnTriangles = 120'000;
inline constexpr size_t kMostTreeBytes = 32 << 20;

// The page's bytes. The same sidecar and mesh give the same page.
//
// path  of the sidecar: the page's title, and for messages
// Errors: those of meshes_of() and why_unclassified(), usage (no objects), runtime (out of memory).
Result<std::string> page_of(const std::string& path, const SidecarContents& sidecar, const PageOptions& options);

}  // namespace vcd::tools
