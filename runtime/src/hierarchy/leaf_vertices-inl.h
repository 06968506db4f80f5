// A coordinate of a leaf's vertices in registers, dealt to the lanes of its triangles.
#if defined(VCD_RUNTIME_HIERARCHY_LEAF_VERTICES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_HIERARCHY_LEAF_VERTICES_INL_H
#undef VCD_RUNTIME_HIERARCHY_LEAF_VERTICES_INL_H
#else
#define VCD_RUNTIME_HIERARCHY_LEAF_VERTICES_INL_H
#endif

#include <array>

#include <vcd/format/hierarchy.h>

#include "lookup/mask_bits-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, kNodeWidth>;
using IndexTag = hn::RebindToSigned<FloatTag>;
inline constexpr size_t kFloatLanes = HWY_LANES(float) < kNodeWidth ? HWY_LANES(float) : kNodeWidth;

// Corners of as many triangles as there are lanes.
HWY_INLINE hn::Vec<IndexTag> corner_indices(const uint8_t* corners) {
  const hn::Rebind<uint8_t, IndexTag> bytes;
  return hn::PromoteTo(IndexTag(), hn::LoadU(bytes, corners));
}

template <uint32_t kVertices>
class LeafVertices {
 public:
  HWY_INLINE void set(size_t first, hn::Vec<FloatTag> values) {
#if HWY_TARGET <= HWY_AVX2
    values_[first / kFloatLanes] = values;
#else
    hn::Store(values, FloatTag(), values_ + first);
#endif
  }

  // For each lane the value of that vertex.
  HWY_INLINE hn::Vec<FloatTag> at(hn::Vec<IndexTag> vertex) const {
    const FloatTag d;
#if HWY_TARGET <= HWY_AVX3
    if constexpr (kVertices == kNodeWidth) return hn::Vec<FloatTag>{_mm512_permutexvar_ps(vertex.raw, values_[0].raw)};
    else return hn::Vec<FloatTag>{_mm512_permutex2var_ps(values_[0].raw, vertex.raw, values_[1].raw)};
#elif HWY_TARGET <= HWY_AVX2
    const auto pick = [&](size_t pair) HWY_ATTR {
      const auto low = hn::Vec<FloatTag>{_mm256_permutevar8x32_ps(values_[2 * pair].raw, vertex.raw)},
                 high = hn::Vec<FloatTag>{_mm256_permutevar8x32_ps(values_[2 * pair + 1].raw, vertex.raw)};
      return hn::Vec<FloatTag>{
          _mm256_blendv_ps(low.raw, high.raw, _mm256_castsi256_ps(_mm256_slli_epi32(vertex.raw, 28)))};
    };
    if constexpr (kVertices == kNodeWidth) return pick(0);
    else
      return hn::Vec<FloatTag>{
          _mm256_blendv_ps(pick(0).raw, pick(1).raw, _mm256_castsi256_ps(_mm256_slli_epi32(vertex.raw, 27)))};
#else
    return hn::GatherIndex(d, values_, hn::And(vertex, hn::Set(IndexTag(), kVertices - 1)));
#endif
  }

 private:
#if HWY_TARGET <= HWY_AVX2
  hn::Vec<FloatTag> values_[kVertices / kFloatLanes];
#else
  alignas(64) float values_[kVertices];
#endif
};

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
