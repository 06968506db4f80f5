#include "memory.h"

#include "limits.h"
#include "readable.h"

namespace vcd::tools {

std::optional<Error> check_memory(const std::string& what, uint64_t bytes_needed) {
  const uint64_t free = available_memory();
  if (free == 0 || bytes_needed <= free) return std::nullopt;
  return Error{ErrorCode::runtime, what + ": too large for this machine: it takes about " +
                                       readable_bytes(bytes_needed) + " of memory, " + readable_bytes(free) +
                                       " are free for it"};
}

}  // namespace vcd::tools
