// Counts of a whole run. What is listed may have a cap; these have none.
#pragma once

#include <map>
#include <string>

#include <vcd/verify/outcome.h>

namespace vcd::verify {

struct Totals {
  uint64_t sidecars = 0, ok = 0, failed = 0, not_verified = 0;  // the first is the sum of the others
  uint64_t stale = 0, orphaned = 0;                             // sidecars
  bool has_library = false;
  uint64_t assets = 0, missing = 0, unusable = 0, unreadable = 0, assets_not_verified = 0;
  uint64_t inputs_failed = 0;
  uint64_t warnings = 0;
  std::map<std::string, uint64_t> failed_by_finding;  // files of any kind with an error of this id
  uint64_t contradictions_seen = 0, contradictions_listed = 0;

  void add(const Outcome& outcome);
};

std::string summary(const Totals& totals);  // a line on sidecars, and one on the library's assets

}  // namespace vcd::verify
