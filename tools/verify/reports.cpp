#include "reports.h"

#include <cstdio>

#include <vcd/writer/atomic_file.h>

#include "common/audit_report.h"
#include "common/paths.h"

namespace vcd::verify {

using namespace baker;
using namespace tools;

namespace {

const char* word_of(Visibility answer) {
  constexpr const char* kWords[] = {"clear", "blocked", "unclassified"};
  return kWords[static_cast<size_t>(answer)];
}
const char* traced(const ObjectCheck::Replay& replay) { return replay.is_blocked ? "blocked" : "clear"; }

Json describe_object_check(const ObjectCheck& object) {
  Json json{{"name", object.name}};
  if (object.audit) {
    json["audit"] = describe_audit(*object.audit);
    json["wrong_rate_at_least"] = object.wrong_rate_at_least;
    json["allowed_wrong_rate"] = object.allowed_wrong_rate;
    json["audit"]["contradictions_seen"] = object.contradictions_seen;
  }
  if (object.replay) json["segment"] = {{"answer", word_of(object.replay->answer)}, {"traced", traced(*object.replay)}};
  return json;
}

std::string line_of(const Contradiction& c) {
  return std::string("  ") + (c.proven ? "proven " : "promised ") + word_of(c.promised) +
         ", and the mesh says otherwise: --segment=" + replayable(c.segment) + "\n";
}

}  // namespace

std::string text_of(const Outcome& outcome) {
  std::string text;
  for (const ObjectCheck& object : outcome.objects) {
    const std::string name = shown(outcome.path) + ": " + object.place;
    if (object.replay)
      text += name + ": the sidecar says " + word_of(object.replay->answer) + ", tracing says " +
              traced(*object.replay) + "\n";
    if (!object.audit) continue;
    text += name + "\n" + audit_summary(*object.audit);
    for (const Contradiction& c : object.audit->contradictions) text += line_of(c);
    if (object.contradictions_seen > object.audit->contradictions.size())
      text += "  and " + std::to_string(object.contradictions_seen - object.audit->contradictions.size()) +
              " more wrong answers\n";
  }
  return text;
}

Json describe_outcome(const Outcome& outcome) {
  Json json{{"file", path_to_json(outcome.path)}, {"findings", Json::array()}};
  Json errors = Json::array();
  for (const Issue& issue : outcome.issues) {
    const bool is_error = issue.severity == Severity::error;
    json["findings"].push_back({{"id", issue.info->id},
                                {"severity", is_error ? "error" : "warning"},
                                {"message", issue.info->message},
                                {"place", issue.place},
                                {"detail", issue.detail},
                                {"byte_offset", issue.in_bytes ? Json(issue.in_bytes->offset) : Json(nullptr)},
                                {"spec_section", issue.info->spec_section}});
    if (is_error) errors.push_back(shown(outcome.path) + ": " + issue.text());
  }
  for (const ObjectCheck& object : outcome.objects) json["objects"].push_back(describe_object_check(object));
  if (outcome.subject == Subject::asset) json["meshes"] = Json::array();
  for (const MeshCheck& mesh : outcome.meshes)
    json["meshes"].push_back({{"source_index", mesh.source_index},
                              {"name", mesh.name},
                              {"geometry_hash", hex(mesh.geometry)},
                              {"has_sidecar", mesh.has_sidecar}});
  json["errors"] = errors;
  json["notes"] = outcome.notes;
  json["exit_code"] = outcome.exit_code();
  return json;
}

Json describe_totals(const Totals& t) {
  Json json{{"sidecars", t.sidecars},
            {"ok", t.ok},
            {"failed", t.failed},
            {"not_verified", t.not_verified},
            {"stale", t.stale},
            {"orphaned", t.orphaned},
            {"inputs_failed", t.inputs_failed},
            {"warnings", t.warnings},
            {"failed_by_finding", t.failed_by_finding},
            {"contradictions_seen", t.contradictions_seen},
            {"contradictions_listed", t.contradictions_listed}};
  if (t.has_library)
    json.update({{"assets", t.assets},
                 {"missing", t.missing},
                 {"unusable", t.unusable},
                 {"unreadable", t.unreadable},
                 {"assets_not_verified", t.assets_not_verified}});
  return json;
}

Json describe_run(const Run& run) {
  Json files = Json::array(), assets = Json::array();
  for (const Outcome& outcome : run.outcomes)
    (outcome.subject == Subject::asset ? assets : files).push_back(describe_outcome(outcome));
  Json json{{"tool", "vc-verify"}, {"version", VCD_VERSION}, {"totals", describe_totals(run.totals)}, {"files", files}};
  if (run.totals.has_library) json["assets"] = assets;
  return json;
}

std::optional<Error> write_report(const std::string& path, const std::string& report) {
  AtomicFile file(path);
  file.append(std::as_bytes(std::span(report)));
  const auto written = file.commit();
  if (written) return std::nullopt;
  return written.error();
}

}  // namespace vcd::verify
