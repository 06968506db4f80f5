// What became of one asset in a run.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <vcd/library/cost.h>
#include <vcd/library/worker.h>

namespace vcd::library {

enum class Fate { waiting, baked, up_to_date, failed, failed_before, not_run };

const char* fate_name(Fate fate);  // "baked", "up-to-date", …

struct Record {
  Fate fate = Fate::waiting;
  std::string reason;  // why it is to be baked: no sidecar yet, the mesh file has changed, …
  Cost cost;           // guessed
  Outcome outcome;     // its code, and what went wrong, or what was baked or is up to date
  double seconds = 0;  // wall time of the last attempt
  uint64_t peak_memory_bytes = 0;
  unsigned threads = 0;
  unsigned attempts = 0;
  std::string old_sidecar;  // failed, and an older sidecar lies there: of what

  bool ok() const { return fate == Fate::baked || fate == Fate::up_to_date; }
};

struct Totals {
  size_t assets = 0, baked = 0, objects_reused = 0, up_to_date = 0, failed = 0, failed_before = 0, not_run = 0;
  uint64_t bytes = 0;

  Totals& operator+=(const Totals& other);
};
Totals totals_of(const std::vector<Record>& records);

}  // namespace vcd::library
