#include "kernels.h"

// Three kinds of x86-64 are enough: SSE4, AVX2 and AVX-512.
#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS HWY_SSSE3
#endif

// This file and what it includes are compiled once for each kind of processor.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <utility>

#include "bits.h"
#include "object_data.h"

#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128  // single calls are faster than these
#include "arrays-inl.h"
#include "bundles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

template <uint32_t... kDepths>
Kernels kernels_of(std::integer_sequence<uint32_t, kDepths...>) {
  return {hwy::TargetName(HWY_TARGET),
          {ManyKernels{&ClassifySegmentsOf<kDepths + 1>, &ClassifyArraysOf<kDepths + 1>, &ClassifyBundleOf<kDepths + 1, QuadBundle>,
                       &ClassifyBundleOf<kDepths + 1, SphereBundle>}...}};
}
Kernels MakeKernels() { return kernels_of(std::make_integer_sequence<uint32_t, kMaxDepth>()); }

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif

#if HWY_ONCE
namespace vcd {
namespace {

// One segment after the other.
template <uint32_t kDepth>
void segments_of(const ObjectData& data, std::span<const Segment> segments, Visibility* answers) {
  for (size_t i = 0; i < segments.size(); ++i) answers[i] = classify(data.frame, data.tree, tree_shape(kDepth), segments[i]);
}
template <uint32_t kDepth>
void arrays_of(const ObjectData& data, const SegmentArrays& segments, Visibility* answers) {
  for (size_t i = 0; i < segments.count; ++i)
    answers[i] = classify(data.frame, data.tree, tree_shape(kDepth), segment_at(segments, i));
}
template <uint32_t kDepth, class Bundle>
void bundle_of(const ObjectData& data, const Bundle& bundle, uint64_t* blocked, uint64_t* open) {
  clear_bits(bundle.size(), blocked, open);
  for (size_t i = 0; i < bundle.size(); ++i)
    set_bits(classify(data.frame, data.tree, tree_shape(kDepth), segment_of(bundle, i)), i, blocked, open);
}
template <uint32_t... kDepths>
Kernels scalar_kernels(std::integer_sequence<uint32_t, kDepths...>) {
  return {"scalar",
          {ManyKernels{&segments_of<kDepths + 1>, &arrays_of<kDepths + 1>, &bundle_of<kDepths + 1, QuadBundle>,
                       &bundle_of<kDepths + 1, SphereBundle>}...}};
}

}  // namespace

std::vector<Kernels> usable_kernels() {
  std::vector<Kernels> usable;
  [[maybe_unused]] const int64_t supported = hwy::SupportedTargets();
#if HWY_TARGETS & HWY_AVX3
  if (supported & HWY_AVX3) usable.push_back(N_AVX3::MakeKernels());
#endif
#if HWY_TARGETS & HWY_AVX2
  if (supported & HWY_AVX2) usable.push_back(N_AVX2::MakeKernels());
#endif
#if HWY_TARGETS & HWY_SSE4
  if (supported & HWY_SSE4) usable.push_back(N_SSE4::MakeKernels());
#endif
#if HWY_TARGETS & HWY_NEON
  if (supported & HWY_NEON) usable.push_back(N_NEON::MakeKernels());
#endif
  usable.push_back(scalar_kernels(std::make_integer_sequence<uint32_t, kMaxDepth>()));
  return usable;
}

bool fits_gathers(const TreeView& tree) {
  constexpr uint64_t kMostWords = uint64_t{1} << 31;
  return tree.block256_count < kMostWords / kBlock256Words && tree.block16_count < kMostWords / kBlock16Words &&
         tree.brick_count < kMostWords / (kBrickBytes / 4);
}

}  // namespace vcd
#endif
