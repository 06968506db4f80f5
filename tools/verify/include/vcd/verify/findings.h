// What vc-verify finds beyond the bytes of a sidecar (those: vcd/format/findings.h), in one table.
#pragma once

#include <vector>

#include <vcd/format/findings.h>

namespace vcd::verify {

// X(identifier, id, severity, message, where in spec/ it is explained)
#define VCD_ISSUES(X)                                                                                                  \
  X(no_such_input, "no-such-input", error, "an input is not there, cannot be searched, or holds no file of its kind",  \
    "")                                                                                                                \
  X(unreadable, "unreadable", error, "the sidecar cannot be read, or takes more memory than there is", "")             \
  X(not_verified, "not-verified", error, "the run was interrupted before this was verified", "")                       \
  X(no_geometry, "no-geometry", error, "a check was asked for that needs a mesh, and none is at hand", "")             \
  X(embedded_geometry, "embedded-geometry", error,                                                                     \
    "the embedded geometry cannot be decoded or is not the object's mesh", "GEOM section")                             \
  X(mesh_unreadable, "mesh-unreadable", error, "the mesh to hold the sidecar against cannot be read", "")              \
  X(mesh_counts, "mesh-counts", error, "an object's triangle and vertex counts are not its mesh's", "OBJT section")    \
  X(box_padding, "box-padding", error, "an object's box is not padded around its mesh as it must be", "Box")           \
  X(hierarchy_triangles, "hierarchy-triangles", error,                                                                 \
    "an object's hierarchy does not hold the triangles of its mesh, each once", "HIER section")                        \
  X(wrong_proven_answer, "wrong-proven-answer", error, "an answer that is given as proven is wrong", "conventions.md") \
  X(wrong_horizon, "wrong-horizon", error, "an answer of an object's horizons is wrong", "HORZ section")                \
  X(wrong_answer_rate, "wrong-answer-rate", error, "more answers are wrong than the method is allowed",                \
    "conventions.md")                                                                                                  \
  X(wrong_answer, "wrong-answer", error, "the answer for the segment that was asked for is wrong", "conventions.md")   \
  X(stale, "stale", error, "the asset that the sidecar was made for has another geometry", "Geometry hash")            \
  X(orphaned, "orphaned", error, "no asset has the sidecar's geometry, and none has its name", "Geometry hash")        \
  X(misnamed, "misnamed", warning, "the sidecar has the name of one asset and the geometry of another",                \
    "Geometry hash")                                                                                                   \
  X(missing, "missing", error, "no sidecar that can be read has the geometry of this asset", "Geometry hash")          \
  X(unreadable_asset, "unreadable-asset", error,                                                                       \
    "the asset could not be read, so nobody knows whether it has a sidecar", "")                                       \
  X(unusable_asset, "unusable-asset", warning, "the asset, or a mesh of it, is none that can be baked", "")

enum class IssueId : uint16_t {
#define VCD_ISSUE_ENUM(name, id, severity, message, section) name,
  VCD_ISSUES(VCD_ISSUE_ENUM)
#undef VCD_ISSUE_ENUM
};

const FindingInfo& issue_info(IssueId id);

// Both tables, the bytes' first. Ids are unique.
const std::vector<const FindingInfo*>& every_finding();

}  // namespace vcd::verify
