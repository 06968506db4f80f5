// Wavefront OBJ (text) to one mesh.
#pragma once

#include <vcd/baker/ingest.h>

#include <filesystem>
#include <string_view>

namespace vcd::baker {

// All objects and groups of the file together, as one mesh named like the file.
//
// Taken: v (x y z; weight and colour are passed over) and f (also fo), with absolute or negative indices and
// any of the forms v, v/vt, v//vn, v/vt/vn; polygons are cut as polygon.h says. vt and vn indices are not
// looked up, since nothing here needs what they name. Lines, points and anything else with a shape (curves,
// surfaces) are passed over with a note. Materials are not read: a face is opaque whatever "d" or "Tr" its
// material states, and a missing .mtl is no error. UTF-8 byte order mark, LF, CR LF or CR line ends, and
// lines that go on after a '\' are understood; UTF-16 is not. Errors: io, invalid_file (with the line
// number), unsupported (UTF-16).
Result<Ingested> ingest_obj(const std::filesystem::path& path, std::string_view bytes, const IngestOptions& options);

}  // namespace vcd::baker
