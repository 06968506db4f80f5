// XXH3-64, the checksum of .vcd files, of bytes in one piece or in several.
#pragma once

#include <cstdint>
#include <span>

#include <vcd/format/bytes.h>

namespace vcd {

uint64_t checksum(Bytes bytes);
uint64_t checksum(std::span<const Bytes> pieces);

}  // namespace vcd
