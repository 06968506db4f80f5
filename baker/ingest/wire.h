// How a child process sends meshes to its parent: a file descriptor that holds one result.
#pragma once

#include <vcd/baker/ingest.h>
#include <vcd/format/error.h>

#include <optional>

namespace vcd::baker {

// Writes value or Error at the start of an empty file, native byte order. Returns false if the system
// refuses. Allocates nothing.
bool write_result(int file, const Result<Ingested>& result);

// Reads it back, from the start. Returns nothing if the file does not hold exactly one whole result, whatever
// it holds instead: no size in it is believed before it is compared with the bytes that remain. Placements
// are of meshes that are there, and invertible. Indices and positions of the meshes are not looked at. May
// throw std::bad_alloc.
std::optional<Result<Ingested>> read_result(int file);

}  // namespace vcd::baker
