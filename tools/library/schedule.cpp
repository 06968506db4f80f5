#include <vcd/library/schedule.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace vcd::library {

bool Schedule::LongestFirst::operator()(size_t a, size_t b) const {
  const double first = (*costs)[a].seconds, second = (*costs)[b].seconds;
  return first != second ? first > second : a < b;
}

Schedule::Schedule(std::vector<Cost> costs, unsigned threads, uint64_t memory_bytes)
    : costs_(std::move(costs)),
      all_threads_(threads),
      free_threads_(threads),
      all_memory_(memory_bytes),
      free_memory_(memory_bytes),
      waiting_(LongestFirst{&costs_}) {
  for (size_t job = 0; job < costs_.size(); ++job) {
    costs_[job].memory_bytes = std::min(costs_[job].memory_bytes, all_memory_);
    seconds_waiting_ += costs_[job].seconds;
    waiting_.insert(job);
  }
}

// With R seconds of work left for T threads, a job of more than R / T would be the last to end: it gets more of them.
// What runs is on average half done.
unsigned Schedule::threads_for(size_t job) const {
  const double left = seconds_waiting_ + seconds_running_ / 2;
  const double share = left > 0 ? costs_[job].seconds * all_threads_ / left : 1;
  return std::clamp(static_cast<unsigned>(std::ceil(share - 0.1)), 1u, all_threads_);
}

std::optional<Grant> Schedule::next() {
  if (waiting_.empty()) return std::nullopt;
  // Only the first: were smaller ones let past, one that needs much might wait for ever.
  const size_t job = *waiting_.begin();
  if (free_threads_ == 0 || costs_[job].memory_bytes > free_memory_) return std::nullopt;
  const Grant grant{job, std::min(threads_for(job), free_threads_), costs_[job].memory_bytes};
  waiting_.erase(waiting_.begin());
  free_threads_ -= grant.threads;
  free_memory_ -= grant.memory_bytes;
  seconds_waiting_ -= costs_[job].seconds;
  seconds_running_ += costs_[job].seconds;
  ++running_;
  return grant;
}

void Schedule::ended(const Grant& grant) {
  free_threads_ += grant.threads;
  free_memory_ += grant.memory_bytes;
  seconds_running_ -= costs_[grant.job].seconds;
  --running_;
}

bool Schedule::again(const Grant& grant, uint64_t memory_bytes) {
  if (grant.memory_bytes >= all_memory_) return false;
  costs_[grant.job].memory_bytes = std::min(memory_bytes, all_memory_);
  seconds_waiting_ += costs_[grant.job].seconds;
  waiting_.insert(grant.job);
  return true;
}

}  // namespace vcd::library
