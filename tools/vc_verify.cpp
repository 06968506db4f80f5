// vc-verify: are sidecars well-formed, do they belong to their meshes, do they keep their promises, and has every mesh
// one?
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <vcd/library/find.h>

#include "common/audit_report.h"
#include "common/limits.h"
#include "common/meshes.h"
#include "common/paths.h"
#include "common/program.h"
#include "verify/reports.h"

namespace {

using namespace vcd;
using namespace vcd::baker;
using namespace vcd::tools;
namespace fs = std::filesystem;

struct Options {
  CommonOptions common;
  verify::RunOptions run;
  std::string segment, sarif, junit;
  std::vector<std::string> allowed;
  bool list_findings = false;
};

int list_findings(const Options& options) {
  Json json = Json::array();
  for (const FindingInfo* info : verify::every_finding()) {
    const char* severity = info->severity == Severity::error ? "error" : "warning";
    json.push_back(
        {{"id", info->id}, {"severity", severity}, {"message", info->message}, {"spec_section", info->spec_section}});
    if (options.common.format == OutputFormat::json) continue;
    const std::string section = *info->spec_section ? std::string(" [") + info->spec_section + "]" : "";
    std::printf("%-24s %-8s %s%s\n", info->id, severity, info->message, section.c_str());
  }
  if (options.common.format == OutputFormat::json) print_json(json);
  return kExitOk;
}

// Why a report must not be written there: over a sidecar or mesh, which is easily done when its name is forgotten.
std::string fault_of_report(const std::string& path, const Options& options) {
  std::error_code ignored;
  const fs::path place = library::place_of(path);
  if (!library::may_be_written(path)) return "a report is not a sidecar or a mesh";
  for (const std::string& input : options.run.inputs)
    if (fs::equivalent(input, path, ignored)) return "is an input, and would be replaced by a report";
  if (!fs::is_directory(place.parent_path(), ignored)) return "its folder does not exist";
  return {};
}

std::string fault_of(Options& options) {
  if (options.run.inputs.empty()) return "no sidecar given; try --help";
  Segment segment;
  if (!options.segment.empty() && !parse_segment(options.segment, segment))
    return options.segment + ": not eight numbers with commas";
  if (!options.segment.empty()) options.run.check.segment = segment;
  for (const std::string& report : {options.sarif, options.junit})
    if (const std::string fault = report.empty() ? "" : fault_of_report(report, options); !fault.empty())
      return shown(report) + ": " + fault;
  if (!options.sarif.empty() && !options.junit.empty() &&
      library::place_of(options.sarif) == library::place_of(options.junit))
    return shown(options.sarif) + ": two reports for one file";
  return {};
}

// Writes what was asked for. Returns the exit code: that of the run, or io where a report is lost and the run was ok.
int write_reports(const Options& options, const verify::Run& run) {
  int code = run.exit_code();
  const auto write = [&](const std::string& path, const std::string& report) {
    const auto fault = verify::write_report(path, report);
    if (!fault) return;
    print_error(shown(fault->message));
    if (code == kExitOk) code = exit_code(fault->code);
  };
  if (!options.junit.empty()) write(options.junit, verify::junit(run));
  if (!options.sarif.empty()) write(options.sarif, verify::sarif(run, code));
  return code;
}

// Its faults on standard error; on standard output what a person wants to see of it.
void print_outcome(const verify::Outcome& outcome, bool quiet) {
  const std::string name = shown(outcome.path) + ": ";
  for (const verify::Issue& issue : outcome.issues) {
    if (issue.severity == Severity::error) print_error(name + issue.text());
    if (issue.severity == Severity::warning && !quiet) print_note(name + issue.text());
  }
  if (quiet) return;
  for (const std::string& note : outcome.notes) print_note(note);
  std::fputs(verify::text_of(outcome).c_str(), stdout);
  if (outcome.subject == verify::Subject::sidecar && !outcome.failed()) std::printf("%sok\n", name.c_str());
}

int run(Options& options) {
  if (options.list_findings) return list_findings(options);
  if (const std::string fault = fault_of(options); !fault.empty()) {
    print_error(fault);
    return exit_code(ErrorCode::usage);
  }
  catch_interruptions();
  if (options.run.threads == 0) options.run.threads = available_processors();
  options.run.allowed = {options.allowed.begin(), options.allowed.end()};
  options.run.check.stop = interrupted;
  const bool is_json = options.common.format == OutputFormat::json;
  const verify::Run run = verify::run(options.run, [&](verify::Outcome& outcome) {
    print_outcome(outcome, options.common.quiet || is_json);
    if (!is_json) outcome.objects.clear(), outcome.meshes.clear();  // shown
  });
  if (is_json) print_json(verify::describe_run(run));
  else if (!options.common.quiet) std::fputs(verify::summary(run.totals).c_str(), stdout);
  return write_reports(options, run);
}

void add_options(CLI::App& app, Options& options) {
  verify::CheckOptions& check = options.run.check;
  app.add_option("files", options.run.inputs,
                 "Sidecars, folders with sidecars anywhere below, patterns (* ? [ ] **); @FILE: a list of them")
      ->type_name("SIDECAR...");
  auto* const against =
      app.add_option("--against", check.against, "The mesh file that the sidecars were baked from")->type_name("MESH");
  app.add_option("--against-library", options.run.against_libraries,
                 "Folder of assets, again for each folder. Each sidecar is checked against the mesh below it that has "
                 "the same\n"
                 "geometry, whatever its name; and each mesh must have a sidecar")
      ->type_name("DIR")
      ->allow_extra_args(false)
      ->excludes(against);
  app.add_option("--allow", options.allowed,
                 "Findings of a library, with commas, that are warnings and no errors; see below")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"orphaned", "missing", "unreadable-asset", "mesh-unreadable"}).description(""))
      ->type_name("orphaned|missing|unreadable-asset|mesh-unreadable");
  app.add_option("-j,--threads", options.run.threads,
                 "Files to check at a time, and threads in all; 0: all processors (default). Each of these files is in "
                 "memory.\n"
                 "The output does not depend on it")
      ->check(CLI::Range(0, 1024));
  app.add_option("--lines", check.audit.lines,
                 "Fresh lines to check, a third of them aimed at the mesh (default: 1000000)")
      ->check(CLI::Range(9, 2000000000));
  app.add_option("--seed", check.audit.seed, "Seed of the fresh lines (default: 1)");
  app.add_option("--keep", check.audit.keep,
                 "Contradictions to list for each object, at most; all are counted (default: 10)");
  app.add_option("--max-wrong", check.max_wrong,
                 "Largest share of wrong answers to accept (default: 0.1, 0.02, 0.005 for 16, 81, 256 samples; hybrid: "
                 "0.001).\n"
                 "An object fails if its share is larger with 95 % confidence, so more lines find more.\n"
                 "A wrong proven answer is never accepted")
      ->check(NumberRange(0.0, 1.0));
  app.add_flag("--allow-outside-files", check.ingest.files_outside,
               "Let a mesh file name files that are not in its folder or below it; for trusted files only");
  app.add_option("--segment", options.segment, "Check this one segment instead: ox,oy,oz,t_min,dx,dy,dz,t_max");
  app.add_option("--sarif", options.sarif, "Write a SARIF 2.1.0 report, too")->type_name("PATH");
  app.add_option("--junit", options.junit, "Write a JUnit XML report, too")->type_name("PATH");
  app.add_flag("--list-findings", options.list_findings, "Print the table of everything that can be found, and stop");
}

constexpr const char* kLibraryHelp = R"(Against a library:
  stale      no mesh has the sidecar's geometry, but its asset is there: found by path (X.vcd beside X, or at the same
             place below its own folder), else by the file name in its provenance. Code 8
  orphaned   no mesh has the sidecar's geometry, and no asset its name. Code 7
  missing    no sidecar has the geometry of a mesh of the asset. Code 7
  unreadable-asset   the asset cannot be read, so it may lack a sidecar. Code 2 or 4
  mesh-unreadable    the sidecar's asset cannot be read, so the sidecar may be stale. Code 2 or 4
  unusable-asset, misnamed   warnings
If a mesh has changed, its asset is missing a sidecar and the old sidecar is stale. Several assets may have one geometry.)";

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Checks .vcd sidecars. First the file, byte by byte. Then, if there is a mesh (--against, --against-library or "
      "embedded\n"
      "geometry), whether the sidecar belongs to it, and its answers against exact arithmetic."};
  add_options(app, options);
  add_common_options(app, options.common);
  app.footer(kLibraryHelp + std::string("\n\n") + app.get_footer());
  return run_program(app, argc, argv, [&] { return run(options); });
}
