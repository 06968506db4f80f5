// OFF (Geomview's Object File Format, text) to one mesh.
#pragma once

#include <vcd/baker/ingest.h>

#include <filesystem>
#include <string_view>

namespace vcd::baker {

// Taken: OFF with any of the prefixes ST, C and N, comments, and the counts on the line of the keyword or
// after it. Each vertex and each face begins a line and may go on over several. What follows the three
// coordinates of a vertex or the last index of a face on its line (normals, colours) is passed over. Errors:
// io, invalid_file (with the line number), unsupported (binary, 4OFF, nOFF).
Result<Ingested> ingest_off(const std::filesystem::path& path, std::string_view bytes, const IngestOptions& options);

}  // namespace vcd::baker
