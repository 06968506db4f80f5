// The paper's classification: stratified sample lines, all blocked, all clear, or mixed.
// Billen and Dutré 2016, section 3.1.
#pragma once

#include <array>
#include <cstdint>

#include <vcd/baker/cell.h>
#include <vcd/baker/tracer.h>

namespace vcd::baker {

// Safe from any thread. The verdict on a cell depends on cell, seed and mesh only.
class SampledClassifier {
 public:
  // samples: 16, 81 or 256 (2^4, 3^4, 4^4 strata). The tracer's mesh is in grid units, and outlives this.
  SampledClassifier(const Tracer& tracer, uint32_t samples, uint64_t seed);

  // Traces packet by packet until both answers were seen. Adds the rays traced to `rays`.
  CellVerdict classify(const Cell& cell, uint64_t& rays) const;

  // The sample lines first … first + count - 1 of a cell: from the pair's first face, at tnear 0, to its second, at
  // tfar 1. count is 1 … lanes; lanes, 8 or 16, are filled, the spare ones with the last sample.
  void fill(const Cell& cell, uint32_t first, uint32_t count, uint32_t lanes, RTCRay16& rays) const;

 private:
  const Tracer& tracer_;
  uint32_t samples_;
  uint32_t strata_;  // along each of s, t, u, v
  uint64_t seed_;
  std::array<std::array<uint8_t, 4>, 256> stratum_{};  // of each sample, in the order in which they are traced
};

}  // namespace vcd::baker
