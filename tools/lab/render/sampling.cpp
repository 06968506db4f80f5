#include "sampling.h"

#include <algorithm>
#include <cmath>

namespace vcd::render {
namespace {

uint64_t mix(uint64_t x) {  // SplitMix64's finalizer (Steele, Lea and Flood 2014)
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
  x = (x ^ x >> 27) * 0x94D049BB133111EBu;
  return x ^ x >> 31;
}

uint32_t morton(uint32_t x, uint32_t y) {
  uint32_t code = 0;
  for (uint32_t bit = 0; bit < 16; ++bit) code |= (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1);
  return code;
}

}  // namespace

Strata make_strata(uint32_t count) {
  auto rows = static_cast<uint32_t>(std::sqrt(static_cast<double>(count)));
  while (count % rows != 0) --rows;
  const uint32_t columns = count / rows;
  std::vector<std::pair<uint32_t, Sample2>> ordered;
  const Sample2 size{1 / static_cast<float>(columns), 1 / static_cast<float>(rows)};
  for (uint32_t y = 0; y < rows; ++y)
    for (uint32_t x = 0; x < columns; ++x)
      ordered.push_back({morton(x, y), {static_cast<float>(x) * size.x, static_cast<float>(y) * size.y}});
  std::sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Strata strata{{}, size};
  for (const auto& [code, corner] : ordered) strata.corners.push_back(corner);
  return strata;
}

Sample2 jitter(uint64_t seed, uint32_t pixel, uint32_t sample, uint32_t light) {
  const uint64_t bits = mix(mix(mix(seed + 0x9E3779B97F4A7C15u) + pixel) + (uint64_t{sample} << 32 | light));
  return {static_cast<float>(bits >> 40) * 0x1p-24f, static_cast<float>(bits >> 16 & 0xFFFFFF) * 0x1p-24f};
}

}  // namespace vcd::render
