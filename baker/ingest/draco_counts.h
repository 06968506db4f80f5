// The element counts that a Draco bitstream declares, read without decoding it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

namespace draco {
class DecoderBuffer;
}

namespace vcd::baker {

struct DracoCounts {
  uint64_t faces = 0;
  uint64_t points = 0;  // for the edgebreaker method: vertices of the connectivity, split ones included
};

// Returns nothing where the header is broken or names a method that is not known.
// buffer: at the start of the stream; left somewhere behind the counts.
std::optional<DracoCounts> read_draco_counts(draco::DecoderBuffer& buffer);

// Entropy coding sets no hard limit, but a practical one: the densest stream that could be made, a flat grid
// of 8 million faces on its own lattice, holds 950 faces a byte. This grants 4096.
bool plausible(const DracoCounts& counts, size_t stream_bytes);

}  // namespace vcd::baker
