// A run over a library: which assets need a bake, their bakes in child processes within one budget of threads and
// memory, and what became of each.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <vcd/library/record.h>
#include <vcd/library/schedule.h>

namespace vcd::library {

struct BatchOptions {
  unsigned threads = 1;
  uint64_t memory_bytes = 0;  // of all processes together
  double time_limit = 0;      // seconds that one asset may take; 0: none
  std::filesystem::path cache;
  bool update = false;                           // leave alone what is up to date, and reuse objects that are
  bool measure = false;                          // BakeContext::measure
  bool fail_fast = false;                        // stop at the first failure
  std::map<std::string, Outcome> failed_before;  // by failure_key(): not to be tried again
  std::function<bool()> stop;                    // asked often; true ends the run
};

// Hears of a run while it goes on, from the caller's thread.
class BatchListener {
 public:
  virtual ~BatchListener() = default;
  struct Running {
    const Asset* asset;
    const Worker* worker;
    double cost_seconds;
  };
  virtual void started(size_t assets, size_t to_bake) = 0;
  virtual void attempt_started(const Asset& asset, const Grant& grant) = 0;  // grant.job means nothing here
  virtual void going_on(const std::vector<Running>& running, size_t ended,
                        double seconds_left) = 0;  // some twenty times a second
  virtual void ended(const Asset& asset, const Record& record) = 0;
};

// The asset, its content, its settings and the baker as one text. Empty where the asset has other files beside its own,
// or cannot be read: then there is no telling whether it would fail again.
std::string failure_key(const Asset& asset);

// One record an asset, in their order; `waiting` where it is to be baked. Hashes files on all threads; none of them is
// left.
std::vector<Record> look_at(const std::vector<Asset>& assets, const BatchOptions& options);

// Bakes what waits. The caller has no other threads. When it returns no child and none of its temporary files is left;
// killed or interrupted, each sidecar is the old or the new one.
void run_batch(const std::vector<Asset>& assets, std::vector<Record>& records, const BatchOptions& options,
               std::span<BatchListener* const> listeners);

}  // namespace vcd::library
