// A budget of threads for one computation.
#pragma once

#include <algorithm>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

namespace vcd::baker {

// Calls `run` where TBB uses at most so many threads; 0: all that there are.
template <class Run>
auto with_threads(unsigned threads, Run&& run) {
  threads = threads == 0 ? static_cast<unsigned>(tbb::info::default_concurrency()) : std::min(threads, 1024u);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  return tbb::task_arena(static_cast<int>(threads)).execute(run);
}

}  // namespace vcd::baker
