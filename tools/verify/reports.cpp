#include "reports.h"

#include <cstdio>

#include <vcd/writer/atomic_file.h>

#include "common/paths.h"
#include "common/program.h"

namespace vcd::verify {

void print_outcome(const Outcome& outcome, bool quiet) {
  const std::string name = shown(outcome.path) + ": ";
  for (const Issue& issue : outcome.issues) {
    if (issue.severity == Severity::error) print_error(name + issue.text());
    if (issue.severity == Severity::warning && !quiet) print_note(name + issue.text());
  }
  if (quiet) return;
  std::fputs(outcome.text.c_str(), stdout);
  if (outcome.subject == Subject::sidecar && !outcome.failed()) std::printf("%sok\n", name.c_str());
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
