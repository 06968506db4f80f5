// Whether something fits into the memory that is free for this process, asked before it is made.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <vcd/format/error.h>

namespace vcd::tools {

// An error (runtime) that names `what`, its need and what is free; nothing where it fits or the system does not tell.
std::optional<Error> check_memory(const std::string& what, uint64_t bytes_needed);

}  // namespace vcd::tools
