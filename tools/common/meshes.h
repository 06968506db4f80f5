// The meshes that a sidecar is held against.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <vcd/baker/ingest.h>
#include <vcd/baker/prepare.h>
#include <vcd/format/contents.h>

namespace vcd::tools {

// "x,y,z" of a shift, shortest that reads back as the same doubles; and back. Nothing for what are not three numbers.
std::string shift_text(const std::array<double, 3>& shift);
std::optional<std::array<double, 3>> parse_shift(std::string_view text);

// Gets a mesh, or why this one cannot be prepared.
using TakeMesh = std::function<void(const std::string& name, uint32_t source_index, Result<baker::PreparedMesh>&&)>;

// Ingests a file in a child process and prepares its meshes one after another. The error of a file that cannot be
// ingested.
std::optional<Error> each_mesh(const std::string& path, const IngestOptions& options, const TakeMesh& take);

// How the mesh file of a sidecar was read, as its provenance says: so it has to be read to be held against the sidecar.
// What no sidecar may decide, whether files outside the folder are read, comes from `base`.
IngestOptions ingest_options_of(const SidecarContents& sidecar, IngestOptions base = {});

// All meshes of a file that can be prepared. Errors: those of the file; if no mesh can be prepared, that of the last.
Result<std::vector<baker::PreparedMesh>> load_meshes(const std::string& path, const IngestOptions& options);

// The mesh that is embedded for an object, decoded in a child process. `path` names the sidecar in messages.
Result<baker::PreparedMesh> embedded_mesh(const std::string& path, const ObjectContents& object);

}  // namespace vcd::tools
