// What a figure must be read with.
#pragma once

#include <string>

#include "common/describe.h"

namespace vcd::bench {

// {"processor", "threads", "memory_bytes", "system", "compiler", "embree", "embree_isa", "pinned"}.
tools::Json describe_machine();
std::string machine_description();  // the same in one line

}  // namespace vcd::bench
