#include "counts.h"

namespace vcd::preload {

constinit thread_local ThreadCounts* counts_of_this_thread = nullptr;

namespace {

constinit std::atomic<ThreadCounts*> all{nullptr};

// The counts of a dead thread go on as those of a new one, so that threads that come and go need no memory.
ThreadCounts* take() {
  for (ThreadCounts* counts = all.load(std::memory_order_acquire); counts; counts = counts->next) {
    bool free = false;
    if (counts->used.compare_exchange_strong(free, true, std::memory_order_acquire)) return counts;
  }
  auto* counts = new ThreadCounts;
  counts->next = all.load(std::memory_order_relaxed);
  while (!all.compare_exchange_weak(counts->next, counts, std::memory_order_release)) {
  }
  return counts;
}

struct GiveBack {
  ThreadCounts* counts;
  ~GiveBack() { counts_of_this_thread = nullptr, counts->used.store(false, std::memory_order_release); }
};

}  // namespace

ThreadCounts& take_thread_counts() noexcept {
  counts_of_this_thread = take();
  thread_local GiveBack at_end{counts_of_this_thread};
  return *counts_of_this_thread;
}

uint64_t total(Count which) {
  uint64_t sum = 0;
  for (const ThreadCounts* counts = all.load(std::memory_order_acquire); counts; counts = counts->next)
    sum += counts->counts[static_cast<size_t>(which)].load(std::memory_order_relaxed);
  return sum;
}

}  // namespace vcd::preload
