// What a demand's cells take as a tree.
#pragma once

#include <cstdint>

#include "demand/divided_cells.h"

namespace vcd::baker {

// At most this, in bytes: what is equal is stored once.
uint64_t bytes_of(const DividedCells& divided);

}  // namespace vcd::baker
