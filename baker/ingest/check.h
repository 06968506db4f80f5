// What every format owes the passes that follow, in one place, and the form of the messages that say
// otherwise.
#pragma once

#include <vcd/baker/ingest.h>
#include <vcd/format/error.h>

#include <filesystem>
#include <optional>
#include <string>

namespace vcd::baker {

// "<file>: <reason>" as an Error.
Error file_error(const std::filesystem::path& path, ErrorCode code, const std::string& reason);

// The last line of defence, whichever reader the meshes come from: at least one mesh, and in each at least
// one triangle, finite positions and indices in range. Returns what is wrong first (code invalid_file; the
// message names file, mesh and element), or nothing. Time is linear in the mesh, memory constant.
std::optional<Error> check_ingested(const std::filesystem::path& path, const Ingested& ingested);

}  // namespace vcd::baker
