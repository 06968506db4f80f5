// STL, binary and text, to one mesh.
#pragma once

#include <vcd/baker/ingest.h>

#include <filesystem>
#include <string_view>

namespace vcd::baker {

// All facets of the file, with three positions of their own each: nothing is welded. Normals and the
// attribute bytes of binary facets are passed over. A file is binary if its size is what the count of facets
// at byte 80 asks for, whatever its header says; else it is text if it begins with "solid" and holds no zero
// byte near its start. A text file may hold several solids; each must be closed by "endsolid", lest a
// truncated file pass for a whole one. Errors: io, invalid_file (with line number, or facet and byte offset),
// unsupported (UTF-16).
Result<Ingested> ingest_stl(const std::filesystem::path& path, std::string_view bytes, const IngestOptions& options);

// Whether the size is what the count of facets asks for, to the byte.
bool size_fits_binary_stl(std::string_view bytes);

}  // namespace vcd::baker
