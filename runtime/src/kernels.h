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

struct ToGrid;
using ClassifyPlaced = void (*)(const ObjectData&, const ToGrid&, const SegmentArrays& whole_runs, Visibility*);

// Those for one depth.
struct ManyKernels {
  ClassifySegments segments;
  ClassifyArrays arrays;
  ClassifyPlaced placed;
  ClassifyQuad quad;
  ClassifySphere sphere;
};

// For scenes: see scene.cpp.
struct SceneData;
struct SceneAnswers;
struct SceneNode;
struct SceneBeam;
struct BeamFrame;
struct BundleChunk;
struct ToFrame;
struct SceneKernels {
  void (*segments)(const SceneData&, std::span<const Segment>, const SceneQuery&, SceneAnswers);
  uint32_t (*boxes_in_beam)(const SceneNode&, const SceneBeam&);
  void (*measure)(BundleChunk&);
  void (*bundle)(const ObjectData&, const ToGrid&, const BeamFrame&, const BundleChunk&, uint32_t live,
                 const float* const (&directions)[3], uint64_t* blocked, uint64_t* open);
  void (*to_object)(const ToGrid&, const ToFrame&, const SegmentArrays& world, float* const (&origin)[3],
                    float* const (&direction)[3]);
};

struct Kernels {
  const char* name;                             // as kernels() in <vcd/runtime/sidecar.h> lists it
  std::array<ManyKernels, kMaxDepth> at_depth;  // depth - 1
  SceneKernels scene;
};

// Those that this processor can run, fastest first. The last is the scalar one, which any other equals bit for bit.
std::vector<Kernels> usable_kernels();

// Whether the pools are small enough for 32-bit gathers: below 8 GiB each. Else only the scalar kernel will do.
bool fits_gathers(const TreeView& tree);

}  // namespace vcd
