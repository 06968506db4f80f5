#include "memory.h"

#include <fstream>

#include "progress.h"

namespace vcd {

std::optional<Error> check_memory(const std::string& what, uint64_t bytes_needed) {
  std::ifstream meminfo("/proc/meminfo");
  std::string key;
  for (uint64_t kib; meminfo >> key >> kib; meminfo.ignore(64, '\n')) {
    if (key != "MemAvailable:") continue;
    if (bytes_needed <= kib * 1024) return std::nullopt;
    return Error{ErrorCode::runtime, what + ": too large for this machine: it takes about " + readable_bytes(bytes_needed) +
                                         " of memory, " + readable_bytes(kib * 1024) + " are free"};
  }
  return std::nullopt;
}

}  // namespace vcd
