#include "audit/audit_object.h"

#include <algorithm>
#include <string>
#include <vector>

#include <vcd/format/line_cell.h>

#include "prepare/place.h"

namespace vcd::baker {
namespace {

Answers answers_of(const ObjectRecord& record, TreeView tree, Trust trust) {
  tree.answers = answer_table(trust);
  return [frame = make_grid_frame(record.box_min, record.box_max), tree](std::span<const Segment> segments,
                                                                         std::span<Visibility> answers) {
    for (size_t i = 0; i < segments.size(); ++i) answers[i] = classify(frame, tree, tree.shape, segments[i]);
  };
}

// A sampled tree proves nothing.
Answers proven_answers_of(const ObjectRecord& record, const TreeView& tree) {
  if (record.method != static_cast<uint8_t>(Method::sampled)) return answers_of(record, tree, Trust::proofs);
  return [](std::span<const Segment>, std::span<Visibility> answers) {
    std::ranges::fill(answers, Visibility::unclassified);
  };
}

}  // namespace

Error wrong_proofs(const PreparedMesh& mesh, uint64_t count, std::span<const Segment> shown) {
  std::string segments;
  for (const Segment& segment : shown) segments += " --segment=" + replayable(segment);
  return {ErrorCode::difference, place_of(mesh) + ": an audit found " + std::to_string(count) +
                                     " wrong proven answers, so nothing is written. This is a fault of vcd, please "
                                     "report it:" +
                                     segments};
}

Result<AuditReport> audit_object(const PreparedMesh& mesh, const ObjectRecord& record, const TreeView& tree,
                                 const AuditOptions& options) {
  const AuditReport report =
      audit(mesh, answers_of(record, tree, Trust::statistics), proven_answers_of(record, tree), options);
  if (options.stop && options.stop()) return Error{ErrorCode::runtime, place_of(mesh) + ": stopped"};
  const uint64_t wrong = report.sum(false).wrong_proven + report.sum(true).wrong_proven;
  std::vector<Segment> shown;
  for (const Contradiction& c : report.contradictions)
    if (c.proven) shown.push_back(c.segment);
  if (wrong > 0) return wrong_proofs(mesh, wrong, shown);
  return report;
}

void record_audit(const AuditReport& report, ObjectRecord& record) {
  const AuditCounts undirected = report.sum(false), aimed = report.sum(true);
  record.audit_lines[0] = undirected.segments, record.audit_lines[1] = aimed.segments;
  record.audit_wrong[0] = undirected.all_wrong(), record.audit_wrong[1] = aimed.all_wrong();
  record.audit_bound_95 = static_cast<float>(upper_bound_95(undirected.all_wrong(), undirected.segments));
}

}  // namespace vcd::baker
