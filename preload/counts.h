// What became of shadow rays, counted by each thread for itself and said at exit; and what each thread found to pay.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "choice.h"
#include "settings.h"

namespace vcd::preload {

enum class Count : size_t {
  clear,           // answered by look-ups; with VCD_ANSWERS=exact by hierarchies too
  blocked,         // the same
  clear_but_rest,  // no mesh with a sidecar is met; Embree traced the rest of the scene
  unclassified,    // Embree traced the whole scene
  held_back,       // the same, though it is blocked: a filter or a mask decides
  not_looked_up,   // the same, since look-ups cost more than they save
  other_scenes,    // the same, of scenes without sidecars or by rtcOccludedNp
  kCount,
};

// Only its own thread writes it; any may read it.
struct ThreadCounts {
  std::array<std::atomic<uint64_t>, static_cast<size_t>(Count::kCount)> counts = {};
  std::array<Choice, 8> choices = {};  // its own thread's alone; of the view with that id modulo 8
  std::atomic<bool> used = true;       // by a living thread
  ThreadCounts* next = nullptr;        // never changes once it is in the list

  void add(Count which, uint64_t more) {
    std::atomic<uint64_t>& count = counts[static_cast<size_t>(which)];
    count.store(count.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
  }
};

extern constinit thread_local ThreadCounts* counts_of_this_thread;
ThreadCounts& take_thread_counts() noexcept;  // ends the program if there is no memory for them

// Of this thread. Never locks; allocates in a thread's first call at most.
inline ThreadCounts& thread_counts() noexcept {
  return counts_of_this_thread ? *counts_of_this_thread : take_thread_counts();
}

inline Choice& choice_of(uint64_t view_id) {
  Choice& choice = thread_counts().choices[view_id % 8];
  if (choice.view_id() != view_id) choice = Choice(view_id, settings().look_up_always);
  return choice;
}

// Of all threads, dead ones too.
uint64_t total(Count which);

}  // namespace vcd::preload
