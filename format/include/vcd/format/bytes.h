// A view of bytes, and how closely they are to be looked at.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace vcd {

using Bytes = std::span<const std::byte>;

// How much of a file is read before it is trusted.
enum class CheckLevel : uint8_t {
  bounds,  // header, tables, and every index: queries are memory-safe; the bricks' bytes are not read
  full,    // and every checksum, padding byte, class and count: what vc-verify reports
};

}  // namespace vcd
