#include <vcd/verify/totals.h>

#include <set>

namespace vcd::verify {
namespace {

std::string counted(uint64_t count, const std::string& what) { return std::to_string(count) + " " + what; }
std::string and_counted(uint64_t count, const std::string& what) {
  return count > 0 ? ", " + counted(count, what) : "";
}

}  // namespace

void Totals::add(const Outcome& outcome) {
  std::set<std::string> errors;
  for (const Issue& issue : outcome.issues) {
    if (issue.severity == Severity::error) errors.insert(issue.info->id);
    if (issue.severity == Severity::warning) ++warnings;
  }
  for (const std::string& id : errors) ++failed_by_finding[id];
  switch (outcome.subject) {
    case Subject::input: ++inputs_failed; break;
    case Subject::sidecar:
      ++sidecars;
      ++(outcome.has(IssueId::not_verified) ? not_verified : outcome.failed() ? failed : ok);
      stale += outcome.has(IssueId::stale);
      orphaned += outcome.has(IssueId::orphaned);
      break;
    case Subject::asset:
      ++assets;
      missing += outcome.has(IssueId::missing);
      unusable += outcome.has(IssueId::unusable_asset);
      unreadable += outcome.has(IssueId::unreadable_asset);
      assets_not_verified += outcome.has(IssueId::not_verified);
      break;
  }
  contradictions_seen += outcome.contradictions_seen;
  contradictions_listed += outcome.contradictions_listed;
}

std::string summary(const Totals& t) {
  std::string by_finding;
  for (const auto& [id, files] : t.failed_by_finding)
    by_finding += (by_finding.empty() ? "" : ", ") + id + " " + std::to_string(files);
  std::string text = counted(t.sidecars, t.sidecars == 1 ? "sidecar: " : "sidecars: ") + counted(t.ok, "ok") +
                     and_counted(t.failed, "failed") + and_counted(t.not_verified, "not verified") +
                     and_counted(t.stale, "stale") + and_counted(t.orphaned, "orphaned") +
                     and_counted(t.inputs_failed, "inputs failed") + and_counted(t.warnings, "warnings") +
                     and_counted(t.contradictions_seen, "wrong answers");
  if (t.contradictions_seen > 0) text += " (" + counted(t.contradictions_listed, "listed)");
  if (!by_finding.empty()) text += "; files by error: " + by_finding;
  text += "\n";
  if (!t.has_library) return text;
  return text + counted(t.assets, t.assets == 1 ? "asset: " : "assets: ") + counted(t.missing, "missing") +
         and_counted(t.unusable, "unusable") + and_counted(t.unreadable, "unreadable") +
         and_counted(t.assets_not_verified, "not verified") + "\n";
}

}  // namespace vcd::verify
