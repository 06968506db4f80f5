#include "horizon/level_codes.h"

#include <algorithm>
#include <utility>

namespace vcd::baker {
namespace {

constexpr uint32_t kFinite = kHorizonNever;  // codes with a finite slope

// Weights of levels.
class LevelCounts {
 public:
  void add(const WeightedLevels& horizon) {
    for (const uint8_t level : *horizon.levels)
      if (level != kNever) weights_[level] += horizon.weight;
  }

  // By dynamic programming over the levels that codes stand for.
  LevelTable best_table() const {
    std::array<double, kLevels + 1> sums{};
    for (size_t i = 0; i < kLevels; ++i) sums[i + 1] = sums[i] + weights_[i];
    // best[i]: what the levels up to i are worth where i is that of the last code so far; from[i][c]: the first level
    // that code c then stands for.
    std::array<double, kLevels> best, next;
    std::array<std::array<uint8_t, kFinite>, kLevels> from{};
    const auto worth = [](size_t i) { return answered_above(static_cast<uint8_t>(i)).worth(); };
    for (size_t i = 0; i < kLevels; ++i) best[i] = sums[i + 1] * worth(i);
    for (uint32_t c = 1; c < kFinite; ++c) {
      for (size_t i = 0; i < kLevels; ++i) {
        next[i] = best[i], from[i][c] = static_cast<uint8_t>(i + 1);  // no level needs it
        for (size_t first = 1; first <= i; ++first) {
          const double value = best[first - 1] + (sums[i + 1] - sums[first]) * worth(i);
          if (value > next[i]) next[i] = value, from[i][c] = static_cast<uint8_t>(first);
        }
      }
      std::swap(best, next);
    }
    LevelTable table;
    table[kHorizonNever] = kNever;
    auto last = static_cast<size_t>(std::ranges::max_element(best) - best.begin());
    for (uint32_t c = kFinite; c-- > 0;) {
      table[c] = static_cast<uint8_t>(last);
      if (from[last][c] > 0) last = from[last][c] - size_t{1};
    }
    return table;
  }

 private:
  std::array<double, kLevels> weights_{};
};

Encoded encode(const Levels& levels, const LevelTable& table, uint32_t number) {
  uint64_t codes = 0;
  Levels coded;
  for (uint32_t s = 0; s < kHorizonSectors; ++s) {
    uint64_t code = 0;
    while (table[code] < levels[s]) ++code;
    codes |= code << (4 * s), coded[s] = table[code];
  }
  return {number, codes, mean(coded)};
}

LevelTables tables_of(const std::array<LevelCounts, kHorizonTables>& counts) {
  LevelTables tables;
  for (uint32_t i = 0; i < kHorizonTables; ++i) tables[i] = counts[i].best_table();
  return tables;
}

}  // namespace

// k-means (Lloyd 1982) on some of them. It begins with groups of those that answer about as much.
LevelTables choose_tables(const std::vector<WeightedLevels>& horizons) {
  constexpr size_t kMost = 16384;
  constexpr int kRounds = 4;
  const size_t step = horizons.size() / kMost + 1;
  std::vector<WeightedLevels> some;
  for (size_t i = 0; i < horizons.size(); i += step) some.push_back(horizons[i]);
  std::ranges::stable_sort(some, {}, [](const WeightedLevels& h) { return mean(*h.levels).worth(); });
  std::array<LevelCounts, kHorizonTables> counts{};
  for (size_t i = 0; i < some.size(); ++i) counts[i * kHorizonTables / some.size()].add(some[i]);
  LevelTables tables = tables_of(counts);
  for (int round = 0; round < kRounds; ++round) {
    counts = {};
    for (const WeightedLevels& horizon : some) counts[encode(*horizon.levels, tables).table].add(horizon);
    tables = tables_of(counts);
  }
  return tables;
}

Encoded encode(const Levels& levels, const LevelTables& tables) {
  Encoded best = encode(levels, tables[0], 0);
  for (uint32_t i = 1; i < kHorizonTables; ++i) {
    const Encoded other = encode(levels, tables[i], i);
    if (other.answered.worth() > best.answered.worth()) best = other;
  }
  return best;
}

float stored_slope(uint8_t level) { return slope_of(level) * (1 + 0x1p-12f) + 0x1p-12f; }

}  // namespace vcd::baker
