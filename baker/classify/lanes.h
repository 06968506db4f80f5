// Sixteen floats at a time, in the vector types that GCC and Clang have on every processor. Each operation is one IEEE
// operation a lane, so that verdicts do not depend on the processor.
#pragma once

#include <cstdint>

#include "classify/shaft.h"

namespace vcd {

typedef float Floats __attribute__((vector_size(64)));
typedef int32_t Ints __attribute__((vector_size(64)));
static_assert(sizeof(Floats) == kLanes * sizeof(float));

[[gnu::always_inline]] inline Floats lanes(const float* at) {
  Floats v;
  __builtin_memcpy(&v, at, sizeof v);
  return v;
}

// Bit k: lane k is true.
[[gnu::always_inline]] inline uint32_t bits_of(const Ints& truth) {
  uint32_t bits = 0;
#ifdef __SSE2__
  typedef float Quarter __attribute__((vector_size(16)));
  Quarter quarters[4];
  __builtin_memcpy(quarters, &truth, sizeof truth);
  for (int i = 0; i < 4; ++i) bits |= static_cast<uint32_t>(__builtin_ia32_movmskps(quarters[i])) << (4 * i);
#else
  for (uint32_t k = 0; k < kLanes; ++k) bits |= (static_cast<uint32_t>(truth[k]) & 1u) << k;
#endif
  return bits;
}

}  // namespace vcd
