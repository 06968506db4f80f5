// A cell of the line space, by its address.
#pragma once

#include <cstdint>

#include <vcd/format/answer.h>

namespace vcd::baker {

// A cell of level l is one of 2^l × 2^l × 2^l × 2^l of its face pair; s, t, u, v < 2^l.
struct Cell {
  uint32_t pair;
  uint32_t level;
  uint32_t s, t, u, v;

  // The i-th of the sixteen children, row-major.
  Cell child(uint32_t i) const {
    return {pair, level + 1, 2 * s + (i >> 3), 2 * t + (i >> 2 & 1), 2 * u + (i >> 1 & 1), 2 * v + (i & 1)};
  }
  Cell parent() const { return {pair, level - 1, s / 2, t / 2, u / 2, v / 2}; }

  bool operator==(const Cell&) const = default;
};

enum class CellVerdict : uint8_t { clear = 0, blocked = 1, mixed = 2 };

// What the recursion knows of a cell, a word: its class in the file, or that its children have to be asked.
inline constexpr auto kClear = static_cast<uint32_t>(CellClass::clear);
inline constexpr auto kBlocked = static_cast<uint32_t>(CellClass::blocked);
inline constexpr auto kUnclassified = static_cast<uint32_t>(CellClass::unclassified);
inline constexpr auto kStatisticallyBlocked = static_cast<uint32_t>(CellClass::statistically_blocked);
inline constexpr uint32_t kDeeper = kStatisticallyBlocked + 1;  // mixed, and not yet at the deepest level

}  // namespace vcd::baker
