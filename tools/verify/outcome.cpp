#include <vcd/verify/outcome.h>

#include <algorithm>

#include "common/paths.h"

namespace vcd::verify {

using namespace tools;

std::string Issue::text() const {
  if (in_bytes) return shown(describe(*in_bytes));
  const std::string what = info->id + std::string(": ") + detail;
  return place.empty() ? what : place + ": " + what;
}

void Outcome::add(const Finding& finding) {
  const FindingInfo& info = finding_info(finding.id);
  issues.push_back({&info, info.severity, error_code(finding.id), "", shown(finding.detail), finding});
}

void Outcome::add(IssueId id, ErrorCode code, const std::string& place, const std::string& detail) {
  const FindingInfo& info = issue_info(id);
  issues.push_back({&info, info.severity, code, shown(place), shown(detail), std::nullopt});
}

bool Outcome::has(IssueId id) const {
  return std::ranges::any_of(issues, [&](const Issue& issue) { return issue.info == &issue_info(id); });
}

int Outcome::exit_code() const {
  const auto error = std::ranges::find(issues, Severity::error, &Issue::severity);
  return error == issues.end() ? 0 : static_cast<int>(error->code);
}

std::string reason(const Error& error, const std::filesystem::path& path) {
  const std::string name = path.string() + ": ";
  return error.message.starts_with(name) ? error.message.substr(name.size()) : error.message;
}

}  // namespace vcd::verify
