// What an asset will cost, guessed from its size and settings before anyone has looked into it. Good enough to start
// the longest first and to share a library out to machines; whoever needs more memory than guessed is run again with
// more.
#pragma once

#include <cstdint>

#include <vcd/library/assets.h>

namespace vcd::library {

struct Cost {
  double seconds = 0;         // on one thread
  uint64_t memory_bytes = 0;  // of the whole process
};

Cost guess_cost(const Asset& asset);

}  // namespace vcd::library
