// Everything that can be wrong with a .vcd file, in one table: programs, JSON and documentation all take it from here.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <vcd/format/error.h>

namespace vcd {

enum class Severity : uint8_t { warning, error };

// X(identifier, id, severity, message, section of spec/vcd-format.md)
#define VCD_FINDINGS(X)                                                                                               \
  X(file_too_short, "file-too-short", error, "the file is shorter than its header", "Header")                         \
  X(bad_magic, "bad-magic", error, "this is not a .vcd file", "Header")                                               \
  X(transfer_damage, "transfer-damage", error, "the magic number was changed by a text-mode transfer", "Header")      \
  X(unsupported_version, "unsupported-version", error, "the major version is not one this reader knows", "Versions")  \
  X(header_checksum, "header-checksum", error, "the header's checksum does not match", "Header")                      \
  X(reserved_not_zero, "reserved-not-zero", error, "a reserved field is not zero", "Reserved fields")                 \
  X(file_size, "file-size", error, "the file is not as long as its header says", "Header")                            \
  X(section_table_range, "section-table-range", error, "the section table does not fit in the file", "Section table") \
  X(section_table_checksum, "section-table-checksum", error, "the section table's checksum does not match",           \
    "Section table")                                                                                                  \
  X(unknown_critical, "unknown-critical", error, "a critical section is of a type this reader does not know",         \
    "Versions")                                                                                                       \
  X(section_flags, "section-flags", error, "a section's flags do not fit its type", "Section table")                  \
  X(section_storage, "section-storage", error, "a section's storage is unknown or not allowed for its type",          \
    "Section table")                                                                                                  \
  X(section_alignment, "section-alignment", error, "a section's alignment is not the one its type and storage need",  \
    "Section table")                                                                                                  \
  X(section_range, "section-range", error,                                                                            \
    "a section does not begin where the one before it ends, or leaves the file", "Section table")                     \
  X(section_size, "section-size", error, "a section's stored and logical sizes do not fit together", "Section table") \
  X(section_object, "section-object", error, "a section names an object that cannot own it", "Section table")         \
  X(section_count, "section-count", error, "a section is missing or stands twice", "Section table")                   \
  X(padding_not_zero, "padding-not-zero", error, "the padding between sections is not zero", "Section table")         \
  X(trailing_bytes, "trailing-bytes", error, "bytes follow the last section", "Section table")                        \
  X(stored_checksum, "stored-checksum", error, "a section's stored bytes do not match their checksum",                \
    "Section table")                                                                                                  \
  X(logical_checksum, "logical-checksum", error, "a section's logical bytes do not match their checksum",             \
    "Section table")                                                                                                  \
  X(zstd_frame, "zstd-frame", error, "a section's stored bytes are not exactly one zstd frame", "Section table")      \
  X(decompression, "decompression", error, "a section's zstd frame cannot be decompressed", "Section table")          \
  X(object_name, "object-name", error, "an object's name leaves the NAME section or is not UTF-8", "OBJT section")    \
  X(object_depth, "object-depth", error, "an object's depth is not 1 to 8", "OBJT section")                           \
  X(object_method, "object-method", error, "an object's method or its parameters are not known", "OBJT section")      \
  X(object_audit, "object-audit", error, "an object's audit contradicts itself or its method", "OBJT section")        \
  X(object_box, "object-box", error, "an object's box is empty, not finite, or too small or large to use",            \
    "OBJT section")                                                                                                   \
  X(object_shift, "object-shift", error, "an object's shift is not finite", "OBJT section")                           \
  X(object_section, "object-section", error, "an object names a section that is not its own", "OBJT section")         \
  X(object_counts, "object-counts", error, "an object's counts do not fit its depth or its TREE section",             \
    "OBJT section")                                                                                                   \
  X(object_statistics, "object-statistics", error, "an object's cell or node counts are not those of its tree",       \
    "OBJT section")                                                                                                   \
  X(names_slack, "names-slack", error, "the NAME section holds bytes that are not one object's name after another's", \
    "NAME section")                                                                                                   \
  X(tree_uniform, "tree-uniform", error, "one of the first three blocks of a pool is not the uniform block",          \
    "TREE section")                                                                                                   \
  X(tree_index, "tree-index", error, "an index points past the end of its pool", "TREE section")                      \
  X(tree_spare, "tree-spare", error, "the spare slot or the padding after the top table is not zero", "TREE section") \
  X(tree_depth, "tree-depth", error, "cells of a tree of depth 1 differ inside a cell of level 1", "TREE section")    \
  X(tree_class, "tree-class", error, "a cell holds a class that its method does not have", "TREE section")            \
  X(tree_unreferenced, "tree-unreferenced", error, "a block is stored that nothing refers to", "TREE section")        \
  X(tree_duplicate, "tree-duplicate", error, "a block is stored twice", "TREE section")                               \
  X(hierarchy_size, "hierarchy-size", error, "a hierarchy's header contradicts its section, its object or itself",    \
    "HIER section")                                                                                                   \
  X(hierarchy_order, "hierarchy-order", error, "a child is not where the layout puts it, or is too deep",             \
    "HIER section")                                                                                                   \
  X(hierarchy_leaf, "hierarchy-leaf", error, "a leaf has an index, a vertex or a padding that it must not have",      \
    "HIER section")                                                                                                   \
  X(hierarchy_box, "hierarchy-box", error, "a box is not that of what is below it", "HIER section")                   \
  X(horizon_size, "horizon-size", error,                                                                              \
    "a horizon section's header contradicts the section or itself, or its object has no hierarchy", "HORZ section")   \
  X(horizon_slopes, "horizon-slopes", error, "the slopes of a horizon section do not ascend to infinity",             \
    "HORZ section")                                                                                                   \
  X(horizon_place, "horizon-place", error, "an entry names no triangle of the object's hierarchy", "HORZ section")    \
  X(provenance, "provenance", error, "the provenance pairs are malformed, unsorted or repeated", "PROV section")

enum class FindingId : uint16_t {
#define VCD_FINDING_ENUM(name, id, severity, message, section) name,
  VCD_FINDINGS(VCD_FINDING_ENUM)
#undef VCD_FINDING_ENUM
};

struct FindingInfo {
  const char* id;
  Severity severity;
  const char* message;
  const char* spec_section;
};

const FindingInfo& finding_info(FindingId id);
std::span<const FindingInfo> all_findings();

struct Finding {
  FindingId id;
  uint64_t offset;     // byte offset in the file where it was seen
  std::string detail;  // the place and the values, for a person; may be empty
};

// "error tree-index at byte 4096: an index points past the end of its pool (…) [TREE section]"
std::string describe(const Finding& finding);

// unsupported for versions and sections of the future, else invalid_file.
ErrorCode error_code(FindingId id);

bool has_error(std::span<const Finding> findings);

}  // namespace vcd
