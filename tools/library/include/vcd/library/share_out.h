// How the objects of a scene share a budget of bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <vcd/baker/bake.h>

namespace vcd::library {

// What an object takes at the least, and what it would do with more.
struct WantedBytes {
  uint64_t least;
  std::vector<baker::WorthOfBytes> worth = {};  // of the bytes of its tree; none: it takes no more
  uint32_t depth = 0;                           // of that tree
};

// What an object gets.
struct Share {
  uint64_t bytes;
  uint32_t depth;
};

// Bytes for each: more go wherever they are worth most, until all are given. Nothing if `total` is less than all take
// at the least.
std::optional<std::vector<uint64_t>> share_out(uint64_t total, std::span<const WantedBytes> wanted);

}  // namespace vcd::library
