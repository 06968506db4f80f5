// EXT_meshopt_compression, and KHR_meshopt_compression as far as its bitstream is the same.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ingest/gltf_document.h"

namespace vcd::baker {

// Decompresses one buffer view, filters included.
//
// Returns count * byteStride bytes. Everything that the decoder asserts, and the size of the result against
// what so few bytes can hold, is checked before it is called; the decoder itself is safe on hostile bytes.
// Throws GltfFailure: invalid_file, unsupported (mode, filter or codec version that this decoder does not
// know). extension: the object on the buffer view. compressed: the bytes that it selects.
std::vector<uint8_t> decode_meshopt(const GltfElement<tinygltf::Value>& extension, std::span<const uint8_t> compressed);

}  // namespace vcd::baker
