// What a baked object holds, and its record.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <vcd/baker/bake.h>
#include <vcd/baker/hierarchy.h>
#include <vcd/format/tree_statistics.h>

#include "octree/dag.h"

namespace vcd::baker {

struct BakedObject::Arrays {
  TreeArrays tree;
  std::vector<std::byte> geometry;  // Draco bytes, or none
  std::vector<uint8_t> clearances;  // kClearanceBytes of them, or none
  HierarchySection hierarchy = {};  // or empty
  AlignedBytes horizons = {};       // or without data
};

// How an object's cells were classified.
struct Classification {
  Method method;
  uint32_t depth;    // 1 … 8
  uint32_t samples;  // that a class by statistics rests on
  uint64_t seed;
};

// The object of a mesh and its tree; counts: measure_tree() of it. The record says all but what an audit found.
BakedObject make_object(const PreparedMesh& mesh, const Classification& classification, const TreeStatistics& counts,
                        BakedObject::Arrays&& arrays);

// The object whose cells answer nothing, since they would not pay. plan: if that was its choice.
BakedObject make_object_without_answers(const PreparedMesh& mesh, std::vector<std::byte>&& geometry,
                                        HierarchySection&& hierarchy, AlignedBytes&& horizons,
                                        std::optional<Plan> plan = {});

}  // namespace vcd::baker
