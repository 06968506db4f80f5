// For programs that measure the baker or the runtime; no bake needs it.
#pragma once

#include <cstdint>

#include <vcd/baker/bake.h>

namespace vcd::baker {

struct BakeTime {
  double seconds = 0;  // that classifying all cells would take
  uint64_t rays = 0;   // traced to find out
};

// Times a bake by a part of it: classifies all cells above the top table, and what is below one in so many cells of
// that table, chosen by a hash of their address and so the same for every method. options: method (not none), depth
// (1 … 8), samples, seed, threads and stop count. Errors: as bake().
Result<BakeTime> time_bake(const PreparedMesh& mesh, const BakeOptions& options, uint32_t one_in);

// An object of which every cell is unclassified, although its record says that it was sampled: to measure what a
// look-up costs where it never helps. depth: 1 … 8.
BakedObject make_unclassified_object(const PreparedMesh& mesh, uint32_t depth);

}  // namespace vcd::baker
