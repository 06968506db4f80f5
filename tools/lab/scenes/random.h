// Random numbers that are the same on every machine: SplitMix64 (Steele, Lea and Flood 2014), and its bits made doubles
// by hand, since the distributions of <random> differ between standard libraries. Draw at most once in an expression:
// compilers evaluate the operands of + and the arguments of a call in orders of their own.
#pragma once

#include <cstdint>

namespace vcd::scenes {

class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t bits() {
    uint64_t z = state_ += 0x9E3779B97F4A7C15;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return z ^ (z >> 31);
  }

  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }  // in [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  Random fork() { return Random(bits()); }  // its numbers do not depend on how many are drawn from this one later

 private:
  uint64_t state_;
};

}  // namespace vcd::scenes
