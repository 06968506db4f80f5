#include <vcd/format/findings.h>

#include <algorithm>
#include <cassert>
#include <iterator>

namespace vcd {
namespace {
constexpr FindingInfo kFindings[] = {
#define VCD_FINDING_INFO(name, id, severity, message, section) {id, Severity::severity, message, section},
    VCD_FINDINGS(VCD_FINDING_INFO)
#undef VCD_FINDING_INFO
};
}  // namespace

const FindingInfo& finding_info(FindingId id) {
  assert(static_cast<size_t>(id) < std::size(kFindings));
  return kFindings[static_cast<size_t>(id)];
}

std::span<const FindingInfo> all_findings() { return kFindings; }

std::string describe(const Finding& finding) {
  const FindingInfo& info = finding_info(finding.id);
  std::string text = info.severity == Severity::error ? "error " : "warning ";
  text += info.id;
  text += " at byte " + std::to_string(finding.offset) + ": " + info.message;
  if (!finding.detail.empty()) text += " (" + finding.detail + ")";
  return text + " [" + info.spec_section + "]";
}

ErrorCode error_code(FindingId id) {
  const bool future = id == FindingId::unsupported_version || id == FindingId::unknown_critical;
  return future ? ErrorCode::unsupported : ErrorCode::invalid_file;
}

bool has_error(std::span<const Finding> findings) {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& f) { return finding_info(f.id).severity == Severity::error; });
}

}  // namespace vcd
