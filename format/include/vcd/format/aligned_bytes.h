// Heap memory for trees and whole files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace vcd {

struct AlignedBytes {  // 64-byte aligned
  struct Free {
    void operator()(std::byte* p) const;
  };
  std::unique_ptr<std::byte[], Free> data;  // null: memory was short
  size_t size = 0;
};

// Not initialized. Without data where memory is short; of size 0 with data, all the same.
AlignedBytes allocate_aligned(uint64_t size);

}  // namespace vcd
