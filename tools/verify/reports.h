// A run as text, JSON, SARIF and JUnit: four views of the same outcomes.
#pragma once

#include <optional>
#include <string>

#include <vcd/verify/run.h>

#include "common/describe.h"

namespace vcd::verify {

using tools::Json;

// What a person wants to see of a sound file, too: its audits. Empty, or lines.
std::string text_of(const Outcome& outcome);

// {"file", "findings", "objects" of a sidecar, "meshes" of an asset, "errors", "exit_code"}
Json describe_outcome(const Outcome& outcome);
Json describe_totals(const Totals& totals);

// {"tool", "version", "totals", "files", and with a library "assets"}
Json describe_run(const Run& run);

// SARIF 2.1.0: one rule for every finding there is, a result for every issue. exit_code: of the program.
std::string sarif(const Run& run, int exit_code);

// JUnit XML, as Jenkins and GitLab read it: a test case for each sidecar and each input that failed, and one for each
// asset with an issue. A case that could not be run is an error, one that found something a failure, an asset with
// warnings alone is skipped.
std::string junit(const Run& run);

// Why the file could not be written, if it could not.
std::optional<Error> write_report(const std::string& path, const std::string& report);

}  // namespace vcd::verify
