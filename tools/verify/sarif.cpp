#include "common/paths.h"
#include "common/uri.h"
#include "reports.h"

namespace vcd::verify {

using namespace tools;
namespace {

const char* level(Severity severity) { return severity == Severity::error ? "error" : "warning"; }

Json rules() {
  Json rules = Json::array();
  for (const FindingInfo* info : every_finding())
    rules.push_back({{"id", info->id},
                     {"shortDescription", {{"text", info->message}}},
                     {"defaultConfiguration", {{"level", level(info->severity)}}},
                     {"properties", {{"specSection", info->spec_section}}}});
  return rules;
}

size_t rule_index(const FindingInfo* info) {
  const auto& all = every_finding();
  return static_cast<size_t>(std::ranges::find(all, info) - all.begin());
}

Json result(const Outcome& outcome, const Issue& issue) {
  Json location{{"physicalLocation", {{"artifactLocation", {{"uri", uri_of(outcome.path)}}}}}};
  if (issue.in_bytes) location["physicalLocation"]["region"]["byteOffset"] = issue.in_bytes->offset;
  if (!issue.place.empty()) location["logicalLocations"] = Json::array({{{"name", issue.place}}});
  return {{"ruleId", issue.info->id},
          {"ruleIndex", rule_index(issue.info)},
          {"level", level(issue.severity)},
          {"message", {{"text", shown(outcome.path) + ": " + issue.text()}}},
          {"locations", Json::array({location})}};
}

}  // namespace

std::string sarif(const Run& run, int exit_code) {
  Json results = Json::array();
  for (const Outcome& outcome : run.outcomes)
    for (const Issue& issue : outcome.issues) results.push_back(result(outcome, issue));
  const bool is_whole = run.totals.not_verified + run.totals.assets_not_verified == 0;
  std::error_code unknown;
  const Json invocation{{"executionSuccessful", is_whole},
                        {"exitCode", exit_code},
                        {"workingDirectory", {{"uri", uri_of(std::filesystem::current_path(unknown) / "")}}}};
  const Json driver{{"name", "vc-verify"}, {"version", VCD_VERSION}, {"rules", rules()}};
  const Json whole{{"$schema", "https://json.schemastore.org/sarif-2.1.0.json"},
                   {"version", "2.1.0"},
                   {"runs", Json::array({{{"tool", {{"driver", driver}}},
                                          {"invocations", Json::array({invocation})},
                                          {"results", results},
                                          {"properties", {{"totals", describe_totals(run.totals)}}}}})}};
  return whole.dump(1) + "\n";
}

}  // namespace vcd::verify
