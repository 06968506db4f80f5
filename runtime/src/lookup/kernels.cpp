#include "lookup/kernels.h"

// Three kinds of x86-64 are enough: SSE4, AVX2 and AVX-512.
#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS HWY_SSSE3
#endif

// This file and what it includes are compiled once for each kind of processor.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lookup/kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <utility>

#include "lookup/scalar_kernels.h"

#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128  // single calls are faster than these
#include "beam/bundles-inl.h"
#include "hierarchy/array-inl.h"
#include "hierarchy/fan-inl.h"
#include "hierarchy/trace-inl.h"
#include "horizon/above-inl.h"
#include "lookup/arrays-inl.h"
#include "scene/pairs-inl.h"
#include "scene/trace-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

template <uint32_t... kDepths>
const Kernels& kernels_of(std::integer_sequence<uint32_t, kDepths...>) {
  static const Kernels kernels = {hwy::TargetName(HWY_TARGET),
                                  {TreeKernelsOf<kDepths + 1>()...},
                                  &ClassifyBundle<QuadBundle>,
                                  &ClassifyBundle<SphereBundle>,
                                  &ClassifyScene,
                                  &ClassifyPlacedBundle,
                                  &BoxesInBeam,
                                  &MeasureChunk,
                                  &ToObject,
                                  &OccludedInScene,
                                  &OccludedArrayInScene,
                                  {&Occluded, &OccludedLookedUp, &OccludedArray, &OccludedFan, &WithoutPassing},
                                  {&IsClear, &AboveArray, &AboveFan}};
  return kernels;
}
const Kernels& TargetKernels() { return kernels_of(std::make_integer_sequence<uint32_t, kMaxDepth>()); }

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif

#if HWY_ONCE
namespace vcd {

std::vector<const Kernels*> usable_kernels() {
  std::vector<const Kernels*> usable;
  [[maybe_unused]] const int64_t supported = hwy::SupportedTargets();
#if HWY_TARGETS & HWY_AVX3
  if (supported & HWY_AVX3) usable.push_back(&N_AVX3::TargetKernels());
#endif
#if HWY_TARGETS & HWY_AVX2
  if (supported & HWY_AVX2) usable.push_back(&N_AVX2::TargetKernels());
#endif
#if HWY_TARGETS & HWY_SSE4
  if (supported & HWY_SSE4) usable.push_back(&N_SSE4::TargetKernels());
#endif
#if HWY_TARGETS & HWY_NEON
  if (supported & HWY_NEON) usable.push_back(&N_NEON::TargetKernels());
#endif
  usable.push_back(&scalar_kernels());
  return usable;
}

const Kernels* kernels_named(std::string_view name) {
  for (const Kernels* kernels : usable_kernels())
    if (name.empty() || name == kernels->name) return kernels;
  return nullptr;
}

const Kernels& kernels_for(const TreeView& tree, const Kernels& wanted) {
  static_assert(kBlockBytes == kBrickBytes);
  constexpr uint32_t kMost = (uint32_t{1} << 31) / kBlockWords;
  const uint32_t largest = std::max(tree.brick_count, *std::ranges::max_element(tree.block_counts));
  return largest < kMost ? wanted : scalar_kernels();
}

}  // namespace vcd
#endif
