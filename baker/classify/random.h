// Random numbers that come from a cell's address, so that no thread's history shows in them.
#pragma once

#include <cstdint>

#include <vcd/baker/cell.h>

namespace vcd::baker {

// SplitMix64's output function (Steele, Lea and Flood 2014): counter in, well-mixed 64 bits out.
inline uint64_t mix_bits(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}
inline constexpr uint64_t kGolden = 0x9E3779B97F4A7C15u;

// The beginning of a cell's own sequence.
inline uint64_t cell_seed(const Cell& c, uint64_t seed) {
  const uint64_t key = uint64_t{c.level} << 36 | uint64_t{c.pair} << 32 | c.s << 24 | c.t << 16 | c.u << 8 | c.v;
  return mix_bits(seed + kGolden * (key + 1));
}

class CellRandom {
 public:
  CellRandom(const Cell& cell, uint64_t seed) : state_(cell_seed(cell, seed)) {}
  double uniform() { return static_cast<double>(mix_bits(state_ += kGolden) >> 11) * 0x1p-53; }  // in [0, 1)

 private:
  uint64_t state_;
};

}  // namespace vcd::baker
