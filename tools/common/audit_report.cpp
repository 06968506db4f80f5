#include "audit_report.h"

#include <algorithm>
#include <cstdio>

namespace vcd::tools {

using namespace baker;

Json describe_counts(const AuditCounts& c) {
  return {{"segments", c.segments},
          {"answered_clear", c.answered[0]},
          {"answered_blocked", c.answered[1]},
          {"wrong_clear", c.wrong[0]},
          {"wrong_blocked", c.wrong[1]},
          {"wrong_proven", c.wrong_proven},
          {"wrong_rate", c.segments ? static_cast<double>(c.all_wrong()) / static_cast<double>(c.segments) : 0.0},
          {"wrong_rate_bound_95", upper_bound_95(c.all_wrong(), c.segments)}};
}

Json describe_audit(const AuditReport& report) {
  Json json;
  for (size_t k = 0; k < kAuditKinds; ++k)
    json["kinds"][audit_kind_name(static_cast<AuditKind>(k))] = describe_counts(report.counts[k]);
  json["undirected"] = describe_counts(report.sum(false));
  json["aimed"] = describe_counts(report.sum(true));
  json["contradictions"] = Json::array();
  for (const Contradiction& c : report.contradictions)
    json["contradictions"].push_back({{"kind", audit_kind_name(c.kind)},
                                      {"segment", replayable(c.segment)},
                                      {"promised", c.promised == Visibility::clear ? "clear" : "blocked"},
                                      {"proven", c.proven}});
  return json;
}

std::string audit_summary(const AuditReport& report) {
  char line[256];
  std::snprintf(line, sizeof line, "  %-9s %10s %9s %9s %11s %11s %7s  %-9s %s\n", "lines", "segments", "clear",
                "blocked", "wrong clear", "wrong blkd", "proven", "wrong", "95 % bound");
  std::string out = line;
  for (size_t k = 0; k < kAuditKinds; ++k) {
    const AuditCounts& c = report.counts[k];
    const double all = static_cast<double>(std::max<uint64_t>(c.segments, 1));
    const auto count = [](uint64_t n) { return static_cast<unsigned long long>(n); };
    std::snprintf(line, sizeof line, "  %-9s %10llu %8.2f%% %8.2f%% %11llu %11llu %7llu  %-9.2g %.2g\n",
                  audit_kind_name(static_cast<AuditKind>(k)), count(c.segments),
                  100 * static_cast<double>(c.answered[0]) / all, 100 * static_cast<double>(c.answered[1]) / all,
                  count(c.wrong[0]), count(c.wrong[1]), count(c.wrong_proven), static_cast<double>(c.all_wrong()) / all,
                  upper_bound_95(c.all_wrong(), c.segments));
    out += line;
  }
  return out;
}

}  // namespace vcd::tools
