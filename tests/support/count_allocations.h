// Counts what operator new hands out in the whole program.
#pragma once

#include <cstdint>

namespace vcd::test {

uint64_t allocation_count();

}  // namespace vcd::test
