// A cell of the line space, by its address.
#pragma once

#include <cstdint>

namespace vcd {

// A cell of level l is one of 2^l × 2^l × 2^l × 2^l of its face pair; s, t, u, v < 2^l.
struct Cell {
  uint32_t pair;
  uint32_t level;
  uint32_t s, t, u, v;

  // The i-th of the sixteen children, row-major.
  Cell child(uint32_t i) const {
    return {pair, level + 1, 2 * s + (i >> 3), 2 * t + (i >> 2 & 1), 2 * u + (i >> 1 & 1), 2 * v + (i & 1)};
  }
};

enum class CellVerdict : uint8_t { clear = 0, blocked = 1, mixed = 2 };

}  // namespace vcd
