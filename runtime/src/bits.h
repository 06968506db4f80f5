// Answers as two bits a segment: blocked, and open (unclassified).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <vcd/format/segment.h>

namespace vcd {

inline void clear_bits(size_t count, uint64_t* blocked, uint64_t* open) {
  std::fill_n(blocked, (count + 63) / 64, uint64_t{0});
  std::fill_n(open, (count + 63) / 64, uint64_t{0});
}

inline void set_bits(Visibility answer, size_t i, uint64_t* blocked, uint64_t* open) {
  const auto a = static_cast<uint64_t>(answer);
  blocked[i / 64] |= (a & 1) << (i % 64);
  open[i / 64] |= (a >> 1) << (i % 64);
}

// The next `count` of them, at most 64, all in one word.
inline uint64_t bits_from(size_t i, size_t count) {
  return (count == 64 ? ~uint64_t{0} : (uint64_t{1} << count) - 1) << (i % 64);
}

}  // namespace vcd
