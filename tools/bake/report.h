// What a run came to: JSON for machines, a page for people, from the same records.
#pragma once

#include <string>
#include <vector>

#include <vcd/library/record.h>

#include "common/describe.h"

namespace vcd::tools {

struct RunReport {
  std::vector<Error> errors;  // of inputs
  std::vector<std::filesystem::path> pruned;
  size_t other_files = 0, named_again = 0;
  double seconds = 0;
  bool dry_run = false;
};

Json record_json(const library::Asset& asset, const library::Record& record);
Json totals_json(const library::Totals& totals);
Json report_json(const std::vector<library::Asset>& assets, const std::vector<library::Record>& records,
                 const RunReport& run);

// From the JSON of one run, or of several merged. It links to the pages of sidecars that the report names, from
// `folder`, where the report's page is to lie.
std::string report_page(const Json& report, const std::filesystem::path& folder);

// NAME.json and NAME.html, with the pages that lie beside sidecars (vc-info --pages). Error: io.
std::optional<Error> write_report(const std::string& name, Json report);

}  // namespace vcd::tools
