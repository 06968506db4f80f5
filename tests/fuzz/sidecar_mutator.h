// Changes what a .vcd file says rather than its bytes, so that most of its checks are passed and the deep ones are met.
#pragma once

#include <cstddef>
#include <cstdint>

namespace vcd::fuzz {

// As LLVMFuzzerCustomMutator. What follows the file's own size is an array of segments; it grows only if with_segments.
size_t mutate_sidecar(uint8_t* data, size_t size, size_t max_size, unsigned int seed, bool with_segments);

}  // namespace vcd::fuzz
