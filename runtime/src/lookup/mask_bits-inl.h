// Masks of lanes as bits in words.
#if defined(VCD_RUNTIME_LOOKUP_MASK_BITS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_LOOKUP_MASK_BITS_INL_H
#undef VCD_RUNTIME_LOOKUP_MASK_BITS_INL_H
#else
#define VCD_RUNTIME_LOOKUP_MASK_BITS_INL_H
#endif

#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Of floats.
template <class D, class M>
HWY_INLINE uint32_t lane_bits(D d, M mask) {
#if HWY_TARGET <= HWY_AVX3
  (void)d;
  return static_cast<uint32_t>(mask.raw);
#elif HWY_TARGET <= HWY_AVX2
  (void)d;
  return static_cast<uint32_t>(_mm256_movemask_ps(mask.raw));
#else
  uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  return bits[0];
#endif
}

// Of bytes.
template <class D, class M>
HWY_INLINE uint64_t byte_bits(D d, M mask) {
#if HWY_TARGET <= HWY_AVX3
  (void)d;
  return static_cast<uint64_t>(mask.raw);
#elif HWY_TARGET <= HWY_AVX2
  (void)d;
  return static_cast<uint32_t>(_mm256_movemask_epi8(mask.raw));
#else
  uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  uint64_t word;
  std::memcpy(&word, bits, sizeof word);
  return word;
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
