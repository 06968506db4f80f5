// From a demand to the cells that are divided for it.
#pragma once

#include <chrono>
#include <span>

#include <vcd/baker/bake.h>
#include <vcd/baker/tracer.h>

#include "demand/best_first.h"
#include "prepare/grid_mesh.h"

namespace vcd::baker {

// What a demand asks of the mesh. Errors (usage): nothing, or nothing that enters its box.
Result<std::span<const AskedSegment>> asked_of(const PreparedMesh& mesh, const Demand& demand);

// Divides cells for the segments that are not kept out. options.budget_bytes is the tree's. Errors: usage (the budget
// is too small for options.depth_elsewhere); runtime (stopped).
Result<BestFirst> divide_for(std::span<const AskedSegment> asked, const GridMesh& grid, const Tracer& tracer,
                             const KnownCells& classifier, const uint8_t* clearances, uint32_t depth,
                             uint64_t budget_bytes, std::chrono::steady_clock::time_point deadline,
                             const BakeOptions& options);

}  // namespace vcd::baker
