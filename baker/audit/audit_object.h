// The audit as a pass of the bake.
#pragma once

#include <vcd/baker/audit.h>
#include <vcd/format/error.h>
#include <vcd/format/layout.h>
#include <vcd/format/tree.h>

namespace vcd::baker {

// Audits a tree before it is written. The answers are those of format's classify(), which the runtime's kernels match
// bit for bit, and the writer reads back what it has written; so what holds here holds for the file.
// Errors: difference (a proven answer is wrong; the message holds the segments); runtime (stopped).
Result<AuditReport> audit_object(const PreparedMesh& mesh, const ObjectRecord& record, const TreeView& tree,
                                 const AuditOptions& options);

// The error (difference) of proven answers that are wrong. shown: some of their segments.
Error wrong_proofs(const PreparedMesh& mesh, uint64_t count, std::span<const Segment> shown);

// Writes what an audit found into the object's record.
void record_audit(const AuditReport& report, ObjectRecord& record);

}  // namespace vcd::baker
