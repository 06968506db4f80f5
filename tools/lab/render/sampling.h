// Where the samples of a pixel and of a light lie.
#pragma once

#include <cstdint>
#include <vector>

namespace vcd::render {

struct Sample2 {
  float x, y;  // 0 … 1
};

// A grid of strata over the unit square, as near to square as the count allows, in an order (Morton's) in which
// neighbours in the list are neighbours in the square: for packets. Each sample is the corner of its stratum; size is
// the stratum's.
struct Strata {
  std::vector<Sample2> corners;
  Sample2 size;
};
Strata make_strata(uint32_t count);

// A sample within a stratum, the same for every stratum of one bundle ("uniform jitter": Ramamoorthi et al., A Theory
// of Monte Carlo Visibility Sampling, 2012). It depends on its arguments only: no state, the same picture for any
// number of threads.
Sample2 jitter(uint64_t seed, uint32_t pixel, uint32_t sample, uint32_t light);

}  // namespace vcd::render
