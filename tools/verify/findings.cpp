#include <vcd/verify/findings.h>

namespace vcd::verify {
namespace {
constexpr FindingInfo kFindings[] = {
#define VCD_ISSUE_INFO(name, id, severity, message, section) {id, Severity::severity, message, section},
    VCD_ISSUES(VCD_ISSUE_INFO)
#undef VCD_ISSUE_INFO
};
}  // namespace

const FindingInfo& issue_info(IssueId id) { return kFindings[static_cast<size_t>(id)]; }

const std::vector<const FindingInfo*>& every_finding() {
  static const std::vector<const FindingInfo*> kAll = [] {
    std::vector<const FindingInfo*> all;
    for (const FindingInfo& info : all_findings()) all.push_back(&info);
    for (const FindingInfo& info : kFindings) all.push_back(&info);
    return all;
  }();
  return kAll;
}

}  // namespace vcd::verify
