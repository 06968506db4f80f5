#include <vcd/format/aligned_bytes.h>

#include <algorithm>
#include <new>

namespace vcd {

void AlignedBytes::Free::operator()(std::byte* p) const { ::operator delete[](p, std::align_val_t{64}); }

AlignedBytes allocate_aligned(uint64_t size) {
  AlignedBytes bytes;
  bytes.data.reset(new (std::align_val_t{64}, std::nothrow) std::byte[std::max<uint64_t>(size, 1)]);
  bytes.size = bytes.data ? size : 0;
  return bytes;
}

}  // namespace vcd
