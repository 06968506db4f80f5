// XXH3-64 over one or several pieces.
#pragma once

#include <cstdint>
#include <span>

#include <vcd/format/contents.h>

namespace vcd {

uint64_t checksum(Bytes bytes);
uint64_t checksum(std::span<const Bytes> pieces);

}  // namespace vcd
