// A view of bytes, and how closely they are to be looked at.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace vcd {

using Bytes = std::span<const std::byte>;

// How closely a file is looked at before it is used. Each level includes those before it; all of them make queries
// memory-safe on any bytes.
enum class CheckLevel : uint8_t {
  bounds,     // header, tables and every index. Damage to the cells themselves is not noticed.
  checksums,  // and every checksum: the bytes are those that were written. For renderers.
  canonical,  // and everything else that vcd-format.md demands of the bytes: padding, classes, counts of cells and
              // nodes, no block twice or unused. For writers and validators: costs some ten times as much as checksums.
};

}  // namespace vcd
