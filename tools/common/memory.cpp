#include "memory.h"

#include <fstream>

#include "readable.h"

namespace vcd::tools {

uint64_t available_memory() {
  std::ifstream meminfo("/proc/meminfo");
  std::string key;
  for (uint64_t kib; meminfo >> key >> kib; meminfo.ignore(64, '\n'))
    if (key == "MemAvailable:") return kib * 1024;
  return 0;
}

std::optional<Error> check_memory(const std::string& what, uint64_t bytes_needed) {
  const uint64_t free = available_memory();
  if (free == 0 || bytes_needed <= free) return std::nullopt;
  return Error{ErrorCode::runtime, what + ": too large for this machine: it takes about " +
                                       readable_bytes(bytes_needed) + " of memory, " + readable_bytes(free) +
                                       " are free"};
}

}  // namespace vcd::tools
