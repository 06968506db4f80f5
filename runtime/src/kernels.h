// What classifies many segments at once, one set of kernels for each kind of processor that they are compiled for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <vcd/format/segment.h>
#include <vcd/format/tree.h>
#include <vcd/runtime/bundle.h>
#include <vcd/runtime/scene.h>
#include <vcd/runtime/segment_arrays.h>

namespace vcd {

struct ObjectData;

using ClassifySegments = void (*)(const ObjectData&, std::span<const Segment>, Visibility*);
using ClassifyArrays = void (*)(const ObjectData&, const SegmentArrays&, Visibility*);
using ClassifyQuad = void (*)(const ObjectData&, const QuadBundle&, uint64_t* blocked, uint64_t* open);
using ClassifySphere = void (*)(const ObjectData&, const SphereBundle&, uint64_t* blocked, uint64_t* open);

// Those for one depth.
struct ManyKernels {
  ClassifySegments segments;
  ClassifyArrays arrays;
  ClassifyQuad quad;
  ClassifySphere sphere;
};

struct SceneData;
struct SceneAnswers;
using ClassifyScene = void (*)(const SceneData&, std::span<const Segment>, const SceneQuery&, SceneAnswers);

struct Kernels {
  const char* name;  // as kernels() in <vcd/runtime/sidecar.h> lists it
  std::array<ManyKernels, kMaxDepth> at_depth;  // depth - 1
  ClassifyScene scene;
};

// Those that this processor can run, fastest first. The last is the scalar one, which any other equals bit for bit.
std::vector<Kernels> usable_kernels();

// Whether the pools are small enough for 32-bit gathers: below 8 GiB each. Else only the scalar kernel will do.
bool fits_gathers(const TreeView& tree);

}  // namespace vcd
