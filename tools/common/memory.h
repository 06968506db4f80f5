// Whether something fits into this machine's memory, asked before it is made.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <vcd/format/error.h>

namespace vcd::tools {

uint64_t available_memory();  // bytes that are free or can be freed; 0 if the system does not say

// An error (runtime) that names `what`, its need and what is free; nothing where it fits or the system does not tell.
std::optional<Error> check_memory(const std::string& what, uint64_t bytes_needed);

}  // namespace vcd::tools
