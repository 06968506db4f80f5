// The recursion over all fifteen face pairs, on many threads, with the same result for any number of them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "octree/dag.h"

namespace vcd::baker {

// done and total count cells of the top table.
using OctreeProgress = std::function<void(uint64_t done, uint64_t total, uint64_t rays)>;

struct Octree {
  TreeArrays tree;
  uint64_t rays = 0;
};

// threads: 0 for all. Nothing if source.stop stopped it. Memory: up to three times the tree's while its arrays grow,
// and a hash table of at most a quarter of it.
std::optional<Octree> build_octree(const CellSource& source, unsigned threads, const OctreeProgress& progress);

}  // namespace vcd::baker
