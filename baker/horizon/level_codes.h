// The slopes that a section can say, chosen for its mesh: a sector has few bits, so it matters which slopes they say.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "horizon/levels.h"

namespace vcd::baker {

using LevelTable = std::array<uint8_t, kHorizonSlopes>;  // ascending; the last is kNever
using LevelTables = std::array<LevelTable, kHorizonTables>;

struct WeightedLevels {
  const Levels* levels;
  double weight;
};

// Tables by which nearly the most is answered, sum of both shares, where each of these takes the best of the tables.
LevelTables choose_tables(const std::vector<WeightedLevels>& horizons);

// The table that answers most, and the codes of the sectors: of the least level in it that is not below the true one.
struct Encoded {
  uint32_t table;
  uint64_t codes;
  Answered answered;  // mean of the sectors
};
Encoded encode(const Levels& levels, const LevelTables& tables);

// As the section has it: with what the floats of a query can add to a slope.
float stored_slope(uint8_t level);

}  // namespace vcd::baker
