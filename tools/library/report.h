// What a run came to: JSON for machines, a page for people, from the same records.
#pragma once

#include <string>
#include <vector>

#include "record.h"

namespace vcd {

struct RunReport {
  std::vector<Error> errors;  // of inputs
  std::vector<std::filesystem::path> pruned;
  size_t other_files = 0, named_again = 0;
  double seconds = 0;
  bool dry_run = false;
};

Json report_json(const std::vector<Asset>& assets, const std::vector<Record>& records, const RunReport& run);

// From the JSON of one run, or of several merged.
std::string report_page(const Json& report);

// NAME.json and NAME.html. Error: io.
std::optional<Error> write_report(const std::string& name, const Json& report);

}  // namespace vcd
