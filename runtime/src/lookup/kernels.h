// The queries' inner loops, one set for each kind of processor that they are compiled for. All sets give the same
// answers, but that the scalar one decides no bundle as a whole.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <vcd/format/segment.h>
#include <vcd/format/tree.h>
#include <vcd/runtime/bundle.h>
#include <vcd/runtime/scene.h>
#include <vcd/runtime/segment_arrays.h>

#include "lookup/sample_bits.h"

namespace vcd {

struct BeamFrame;
struct BundleChunk;
struct SceneAnswers;
struct SceneBeam;
struct SceneData;
struct SceneNode;
struct ToFrame;
struct Fan;
struct Horizons;
struct ReachBox;
struct ToGrid;
struct Traced;

// Those for trees of one depth, so that every shift and mask is a constant.
struct TreeKernels {
  void (*segments)(const GridFrame&, const TreeView&, std::span<const Segment>, Visibility*) noexcept;
  void (*arrays)(const GridFrame&, const TreeView&, const SegmentArrays&, Visibility*) noexcept;
  void (*placed)(const ToGrid&, const TreeView&, const SegmentArrays&, Visibility*) noexcept;
};

// A tree with the kernels for its depth.
struct LookUp {
  const TreeView* tree;
  const TreeKernels* kernels;
};

// Segments of a bundle in an instance's grid. directions: of all the chunk's segments, whole runs of them. Only runs
// whose bit in `live` is set are answered.
struct PlacedBundle {
  const ToGrid& grid;
  const BeamFrame& frame;
  const BundleChunk& chunk;
  uint32_t live;
  const float* const (&directions)[3];
};

// The look-up of one segment.
struct LookUpOne {
  const GridFrame& frame;
  const TreeView& tree;
  Visibility (*classify)(const GridFrame&, const TreeView&, const Segment&) noexcept;
};

// Of hierarchies.
struct TraceKernels {
  bool (*one)(const Traced&, const Segment&) noexcept;
  // The same, but what meets the object's box is looked up before its hierarchy is asked. Most rays of a path tracer
  // miss the box, and a look-up finds that out later.
  bool (*one_looked_up)(const Traced&, const LookUpOne&, const Segment&) noexcept;
  // Those of `live` that are blocked; of at most kChunk segments.
  SampleBits (*array)(const Traced&, const Segment*, const SampleBits& live) noexcept;
  SampleBits (*fan)(const Traced&, const Fan&) noexcept;
  // `live`, of at most kChunk segments, without some that pass by the box for certain.
  SampleBits (*without_passing)(const ReachBox&, const Segment*, const SampleBits& live) noexcept;
};

// Of horizons: <horizon/above.h>.
struct HorizonKernels {
  bool (*one)(const Horizons&, const Segment&, uint32_t primitive) noexcept;
  SampleBits (*array)(const Horizons&, const Segment*, const uint32_t* primitives, size_t count) noexcept;
  SampleBits (*fan)(const Horizons&, const Fan&, uint32_t primitive) noexcept;
};

struct Kernels {
  const char* name;                             // as kernels() in <vcd/runtime/sidecar.h> lists it
  std::array<TreeKernels, kMaxDepth> at_depth;  // depth - 1

  void (*quad)(const GridFrame&, const LookUp&, const QuadBundle&, uint64_t* blocked, uint64_t* unclassified) noexcept;
  void (*sphere)(const GridFrame&, const LookUp&, const SphereBundle&, uint64_t* blocked,
                 uint64_t* unclassified) noexcept;

  // Of scenes.
  void (*scene_segments)(const SceneData&, std::span<const Segment>, const SceneQuery&, SceneAnswers) noexcept;
  void (*scene_bundle)(const LookUp&, const PlacedBundle&, SampleAnswers&) noexcept;
  uint32_t (*boxes_in_beam)(const SceneNode&, const SceneBeam&) noexcept;
  void (*measure)(BundleChunk&) noexcept;
  void (*to_object)(const ToGrid&, const ToFrame&, const SegmentArrays& world, float* const (&origin)[3],
                    float* const (&direction)[3]) noexcept;

  bool (*occluded_in_scene)(const SceneData&, const Segment&, const SceneQuery&) noexcept;
  SampleBits (*occluded_array_in_scene)(const SceneData&, std::span<const Segment>, const SceneQuery&) noexcept;

  TraceKernels trace;
  HorizonKernels horizon;
};

// Those that this processor can run, fastest first. The last is the scalar set.
std::vector<const Kernels*> usable_kernels();
// The one of that name, the fastest for an empty name, or null.
const Kernels* kernels_named(std::string_view name);

// The set for this tree: the wanted one, but scalar where pools are too large for 32-bit gathers, 8 GiB each.
const Kernels& kernels_for(const TreeView& tree, const Kernels& wanted);

}  // namespace vcd
