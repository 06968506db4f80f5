// Which job to start next, on how many threads: the longest first, small ones side by side, one that would outlast all
// others on several threads; never more threads or memory than there are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include <vcd/library/cost.h>

namespace vcd::library {

struct Grant {
  size_t job;
  unsigned threads;
  uint64_t memory_bytes;
};

// Pure bookkeeping: knows no clock and no processes.
class Schedule {
 public:
  // threads >= 1. A job that is guessed to need more memory than there is gets all of it, alone.
  Schedule(std::vector<Cost> costs, unsigned threads, uint64_t memory_bytes);
  Schedule(const Schedule&) = delete;
  Schedule& operator=(const Schedule&) = delete;

  // The job to start now; nothing if none waits, or until another has ended.
  std::optional<Grant> next();
  void ended(const Grant& grant);
  // After ended(): once more, with so much memory. False if it had all there is.
  bool again(const Grant& grant, uint64_t memory_bytes);
  void drop_waiting() { waiting_.clear(); }

  bool idle() const { return waiting_.empty() && running_ == 0; }
  double seconds_waiting() const { return seconds_waiting_; }  // guessed, on one thread

 private:
  struct LongestFirst {
    const std::vector<Cost>* costs;
    bool operator()(size_t a, size_t b) const;
  };
  unsigned threads_for(size_t job) const;

  std::vector<Cost> costs_;
  unsigned all_threads_, free_threads_;
  uint64_t all_memory_, free_memory_;
  double seconds_waiting_ = 0, seconds_running_ = 0;
  size_t running_ = 0;
  std::set<size_t, LongestFirst> waiting_;
};

}  // namespace vcd::library
