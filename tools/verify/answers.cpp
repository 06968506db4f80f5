#include "answers.h"

#include <cstdio>

#include <vcd/baker/audit_horizons.h>
#include <vcd/baker/referee.h>

#include "common/audit_report.h"
#include "mesh_source.h"

namespace vcd::verify {

using namespace baker;
using namespace tools;
namespace {

// The highest share of wrong answers that is forgiven. The sampled method promises nothing about single lines; this
// only tells a poor tree from a broken one. About one and a half times the worst seen over some 240 real meshes, which
// was a shallow tray at depth 4; compact meshes are ten times better.
double allowed_wrong(const ObjectRecord& record) {
  if (record.method == static_cast<uint8_t>(Method::hybrid)) return 0.001;
  switch (record.method_parameters[0]) {
    case 16: return 0.1;
    case 81: return 0.02;
    default: return 0.005;
  }
}

// An audit asks from within TBB's loops, which an exception ends early.
Answers interruptible(const Object& object, const CheckOptions& options) {
  return [answers = answers_of(object), &options](std::span<const Segment> segments, std::span<Visibility> given) {
    if (options.stop()) throw Interrupted{};
    answers(segments, given);
  };
}

void audit_object(const Answering& answering, const PreparedMesh& mesh, const std::string& place,
                  const CheckOptions& options, Outcome& outcome, ObjectCheck& check) {
  const AuditReport report =
      audit(mesh, interruptible(answering.all, options), interruptible(answering.proven, options), options.audit);
  const AuditCounts undirected = report.sum(false), aimed = report.sum(true);
  const uint64_t wrong_proven = undirected.wrong_proven + aimed.wrong_proven;
  // A few lines that happen to be wrong are no sign of a poor tree: only what chance explains in fewer than one audit
  // of twenty is held against it.
  const double rate = lower_bound_95(undirected.all_wrong(), undirected.segments);
  const double allowed = options.max_wrong >= 0 ? options.max_wrong : allowed_wrong(answering.all.record());
  check.contradictions_seen = undirected.all_wrong() + aimed.all_wrong();
  check.wrong_rate_at_least = rate;
  check.allowed_wrong_rate = allowed;
  outcome.contradictions_seen += check.contradictions_seen;
  outcome.contradictions_listed += report.contradictions.size();
  check.audit = report;
  if (wrong_proven > 0)
    return outcome.add(IssueId::wrong_proven_answer, ErrorCode::difference, place,
                       std::to_string(wrong_proven) + " of its proven answers are wrong");
  if (rate <= allowed) return;
  char message[160];
  std::snprintf(message, sizeof message, "at least %.3g of its answers are wrong (95 %% sure), %.3g are allowed", rate,
                allowed);
  outcome.add(IssueId::wrong_answer_rate, ErrorCode::difference, place, message);
}

void replay(const Object& object, const PreparedMesh& mesh, const std::string& place, const Segment& segment,
            Outcome& outcome, ObjectCheck& check) {
  const Visibility answer = object.classify(segment);
  const bool blocked = Referee(mesh).occluded(segment);
  check.replay = {answer, blocked};
  if (answer != Visibility::unclassified && (answer == Visibility::blocked) != blocked)
    outcome.add(IssueId::wrong_answer, ErrorCode::difference, place, "the segment's answer is wrong");
}

}  // namespace

void check_horizons(const ObjectContents& object, const PreparedMesh& mesh, const std::string& place,
                    const CheckOptions& options, Outcome& outcome) {
  const HorizonAudit audit =
      audit_horizons(mesh, object.hierarchy, object.horizon, options.audit.lines / 4, options.stop);
  if (audit.stopped) throw Interrupted{};
  if (audit.wrong > 0)
    outcome.add(IssueId::wrong_horizon, ErrorCode::difference, place,
                std::to_string(audit.wrong) + " of " + std::to_string(audit.clear) + " answers are wrong");
}

void check_answers(const Answering& answering, const PreparedMesh& mesh, const std::string& place,
                   const CheckOptions& options, Outcome& outcome, ObjectCheck& check) {
  if (options.segment) return replay(answering.all, mesh, place, *options.segment, outcome, check);
  audit_object(answering, mesh, place, options, outcome, check);
}

}  // namespace vcd::verify
