// PLY (Stanford polygon files: text, binary of either byte order) to one mesh.
#pragma once

#include <vcd/baker/ingest.h>

#include <filesystem>
#include <string_view>

namespace vcd::baker {

// Taken: x, y, z of the element "vertex", of any scalar type; the list vertex_indices (or vertex_index) of
// "face", cut as polygon.h says; the same list of "tristrips", whose strips begin anew after -1 and turn
// every second triangle around. Other elements and properties, colours and their alpha included, are passed
// over: a face is opaque whatever they say. A text file has one element a line; what a line holds beyond what
// the header announces is passed over with a note. Errors: io, invalid_file (with line number, or element and
// byte offset).
Result<Ingested> ingest_ply(const std::filesystem::path& path, std::string_view bytes, const IngestOptions& options);

}  // namespace vcd::baker
