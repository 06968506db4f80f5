// Sixteen floats at a time. Included once for each kind of processor.
#if defined(VCD_BAKER_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_BAKER_LANES_INL_H
#undef VCD_BAKER_LANES_INL_H
#else
#define VCD_BAKER_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace vcd::baker {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 16>;
using Floats = hn::VFromD<Tag>;
using Truth = decltype(hn::FirstN(Tag(), 0));
constexpr size_t kStep = hn::MaxLanes(Tag());

HWY_INLINE Floats load(const float* at) { return hn::LoadU(Tag(), at); }
HWY_INLINE Floats all(float x) { return hn::Set(Tag(), x); }
HWY_INLINE Truth never() { return hn::FirstN(Tag(), 0); }
HWY_INLINE uint32_t bits_of(Truth truth) {
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(Tag(), truth, bytes);
  return static_cast<uint32_t>(bytes[0] | bytes[1] << 8);
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd::baker
HWY_AFTER_NAMESPACE();
#endif
