#include <vcd/baker/sampled.h>

#include <algorithm>

#include <vcd/format/line_cell.h>

#include "classify/random.h"

namespace vcd::baker {
SampledClassifier::SampledClassifier(const Tracer& tracer, uint32_t samples, uint64_t seed)
    : tracer_(tracer),
      samples_(samples),
      strata_(samples == 16   ? 2
              : samples == 81 ? 3
                              : 4),
      seed_(seed) {
  // The order spreads the first packets of eight and sixteen over the whole cell, since most mixed cells are found out
  // there: for 2 and 4 strata, eight halves of even parity, then the odd ones.
  for (uint32_t i = 0; i < samples; ++i) {
    const uint32_t parity = (i ^ i >> 1 ^ i >> 2) & 1;
    const uint32_t half = (i & 15) ^ parity << 3, quarter = (i >> 4) ^ half;
    for (uint32_t d = 0; d < 4; ++d) {
      const uint32_t h = half >> d & 1, q = quarter >> d & 1;
      constexpr uint32_t kPowers[] = {1, 3, 9, 27};
      stratum_[i][d] = static_cast<uint8_t>(strata_ == 2 ? h : strata_ == 4 ? 2 * h + q : i * 50 % 81 / kPowers[d] % 3);
    }
  }
}

void SampledClassifier::fill(const Cell& cell, uint32_t first, uint32_t count, uint32_t lanes, RTCRay16& rays) const {
  float* const origin[3] = {rays.org_x, rays.org_y, rays.org_z};
  float* const direction[3] = {rays.dir_x, rays.dir_y, rays.dir_z};
  const FaceAxes low = face_axes(kFacePair[cell.pair].low), high = face_axes(kFacePair[cell.pair].high);
  const float width = kGrid / static_cast<float>(1u << cell.level);
  const float step = width / static_cast<float>(strata_);
  const float s0 = static_cast<float>(cell.s) * width, t0 = static_cast<float>(cell.t) * width;
  const float u0 = static_cast<float>(cell.u) * width, v0 = static_cast<float>(cell.v) * width;
  const float low_plane = kFacePair[cell.pair].low % 2 ? kGrid : 0.0f;
  const float high_plane = kFacePair[cell.pair].high % 2 ? kGrid : 0.0f;
  const uint64_t base = cell_seed(cell, seed_);

  alignas(64) float target[3][16];
  for (uint32_t k = 0; k < lanes; ++k) {
    const uint32_t sample = first + std::min(k, count - 1);
    const uint64_t random = mix_bits(base + kGolden * (sample + 1));
    const auto& stratum = stratum_[sample];
    const auto offset = [&](uint32_t d) {
      return (static_cast<float>(stratum[d]) + static_cast<float>(random >> (16 * d) & 0xFFFF) * 0x1p-16f) * step;
    };
    origin[low.normal][k] = low_plane;
    origin[low.first][k] = s0 + offset(0);
    origin[low.second][k] = t0 + offset(1);
    target[high.normal][k] = high_plane;
    target[high.first][k] = u0 + offset(2);
    target[high.second][k] = v0 + offset(3);
  }
  for (int a = 0; a < 3; ++a)
    for (uint32_t k = 0; k < lanes; ++k) direction[a][k] = target[a][k] - origin[a][k];
  for (uint32_t k = 0; k < lanes; ++k) {
    rays.tnear[k] = 0.0f;
    rays.tfar[k] = 1.0f;
    rays.time[k] = 0.0f;
    rays.mask[k] = 0xFFFFFFFF;
    rays.id[k] = 0;
    rays.flags[k] = 0;
  }
}

CellVerdict SampledClassifier::classify(const Cell& cell, uint64_t& rays) const {
  const uint32_t width = tracer_.packet_width();
  const bool coherent = cell.level >= 4;  // wider shafts trace faster without the flag
  bool any_blocked = false, any_clear = false;
  for (uint32_t first = 0; first < samples_; first += width) {
    const uint32_t count = std::min(samples_ - first, width);
    RTCRay16 packet;
    fill(cell, first, count, width, packet);
    const uint32_t blocked = tracer_.occluded(packet, count, coherent);
    rays += count;
    any_blocked |= blocked != 0;
    any_clear |= blocked != (1u << count) - 1;
    if (any_blocked && any_clear) return CellVerdict::mixed;
  }
  return any_blocked ? CellVerdict::blocked : CellVerdict::clear;
}

}  // namespace vcd::baker
