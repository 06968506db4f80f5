// Random floats for tests, the same everywhere.
#pragma once

#include <cstdint>
#include <random>

namespace vcd::test {

class FloatRandom {
 public:
  explicit FloatRandom(uint64_t seed) : engine_(seed) {}
  uint32_t below(uint32_t n) { return static_cast<uint32_t>(engine_() % n); }
  float uniform() { return static_cast<float>(engine_() >> 40) * 0x1p-24f; }
  float between(float low, float high) { return low + (high - low) * uniform(); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace vcd::test
