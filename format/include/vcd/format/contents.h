// A .vcd file taken apart: the only reader and the only validator. The runtime, the programs and the tests use it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <vcd/format/aligned_bytes.h>
#include <vcd/format/bytes.h>
#include <vcd/format/findings.h>
#include <vcd/format/geometry_hash.h>
#include <vcd/format/hierarchy.h>
#include <vcd/format/horizon.h>
#include <vcd/format/layout.h>
#include <vcd/format/tree.h>

namespace vcd {

struct ObjectContents {
  const ObjectRecord* record = nullptr;
  std::string_view name;
  TreeView tree{};            // of Method::none: one that is not in the file, and in which every cell is unclassified
  Bytes geometry = {};        // Draco bytes, empty where none are embedded
  HierarchyView hierarchy{};  // none where the file has none of this object
  HorizonView horizon{};      // likewise
  Bytes clearance = {};       // kClearanceBytes bytes, or empty; tree.clearances points to them
};

// Everything points into the file's bytes, which the caller keeps alive and unchanged, or into `inflated`.
struct SidecarContents {
  const FileHeader* header = nullptr;
  std::span<const SectionEntry> sections;
  std::vector<ObjectContents> objects;
  std::vector<std::pair<std::string_view, std::string_view>> provenance;  // sorted by key
  std::vector<AlignedBytes> inflated;
};

// Reads a whole sidecar.
//
// Throws nothing but std::bad_alloc. Safe on any bytes: every count is bounded by the bytes behind it before it is
// used, and memory use is at most a small multiple of the sizes that largest_logical_size() allows for the file.
// Returns the contents when no error was found; what was found, warnings too, is appended to `findings` in the order of
// the bytes. At most one finding of a kind is reported per section or object.
//
// file      the bytes of the whole file; they must be 8-byte aligned; raw trees are used in place when they are 64-byte
//           aligned (a page-aligned map always is) and copied otherwise
// level     how closely to look
// findings  is appended to
std::optional<SidecarContents> read_sidecar(Bytes file, CheckLevel level, std::vector<Finding>& findings);

// The geometry hashes of a sidecar's objects, in their order. Reads its tables only, whatever the file's size; the file
// must be as read_sidecar takes it. Errors: the first finding, naming the file. Throws nothing but std::bad_alloc.
Result<std::vector<GeometryHash>> read_geometry_hashes(Bytes file, const std::string& name);

// The first error among what read_sidecar found in a file that it refused, as an Error that names the file.
Error first_error(const std::string& name, std::span<const Finding> findings);

// "TREE"; bytes that are no letters as \xNN.
std::string section_type_name(uint32_t type);

// The logical bytes of one section, decompressed if need be. read_sidecar must have accepted the file that the entry is
// of. Empty when out of memory.
AlignedBytes section_bytes(Bytes file, const SectionEntry& section);

}  // namespace vcd
