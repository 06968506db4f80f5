// Loop subdivision of what was read.
#pragma once

#include <vcd/baker/ingest.h>
#include <vcd/format/error.h>

#include <cstdint>
#include <filesystem>
#include <optional>

namespace vcd::baker {

// Subdivides each mesh `times` times by Loop's scheme (Loop 1987; OpenMesh's LoopT): each triangle becomes four, and
// vertices move as the scheme says, those of boundaries along them. Vertices with equal positions are one, but where
// triangles touch in a point without an edge there, each fan of them gets a vertex of its own. Triangles with two equal
// corners, and second ones with the same three corners, are passed over. Both give notes. A mesh without other
// triangles stays as it is.
//
// Errors name file and mesh: unsupported where the mesh is no surface (more than two triangles share an edge, or a
// piece has one side only) or too many triangles would come of it; runtime where they would take more memory than there
// may be (RLIMIT_DATA). Both are known before that memory is used.
//
// The result depends on the triangles and their winding alone, not on their order, machine or threads: all is computed
// in double precision in a fixed order and rounded to floats once. The weights of the scheme, which need a cosine, are
// taken to 24 bits, which any library's cosine agrees on.
std::optional<Error> subdivide(const std::filesystem::path& path, uint32_t times, Ingested& ingested);

}  // namespace vcd::baker
