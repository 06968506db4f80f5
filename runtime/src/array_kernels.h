// Kernels that classify many segments at once, one set for each kind of processor that they are compiled for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <vcd/format/segment.h>
#include <vcd/format/tree.h>
#include <vcd/runtime/segment_arrays.h>

namespace vcd {

struct ObjectData;

using ClassifySegments = void (*)(const ObjectData&, std::span<const Segment>, Visibility*);
using ClassifyArrays = void (*)(const ObjectData&, const SegmentArrays&, Visibility*);

struct ArrayKernels {
  const char* name;  // as array_kernels() in <vcd/runtime/sidecar.h> lists it
  std::array<ClassifySegments, kMaxDepth> segments;  // by depth - 1
  std::array<ClassifyArrays, kMaxDepth> arrays;
};

// Those that this processor can run, fastest first. The last is the scalar one, which any other equals bit for bit.
std::vector<ArrayKernels> usable_kernels();

// Whether the pools are small enough for 32-bit gathers: below 8 GiB each. Else only the scalar kernel will do.
bool fits_gathers(const TreeView& tree);

}  // namespace vcd
