// Accessors: typed arrays over buffer views.
#pragma once

#include <vcd/baker/mesh.h>

#include <cstdint>
#include <vector>

#include "ingest/gltf_buffers.h"

namespace vcd::baker {

// How an accessor stores its elements.
struct GltfElementType {
  int component = TINYGLTF_COMPONENT_TYPE_FLOAT;
  bool normalized = false;
};

// What a POSITION accessor declares: VEC3 of float, or, with KHR_mesh_quantization, of 8 or 16-bit integers.
struct GltfPositionAccessor {
  GltfElementType type;
  uint64_t count = 0;
};
GltfPositionAccessor check_position_accessor(const GltfDocument& document, uint32_t accessor);

bool is_empty_accessor(const GltfDocument& document, uint32_t accessor);  // its count is 0

// How many indices an accessor declares; it must be a SCALAR of unsigned integers.
uint64_t check_index_accessor(const GltfDocument& document, uint32_t accessor);

// Elements of a checked accessor, its sparse substitutions applied. Every range is checked before it is
// multiplied, allocated or read. An accessor without a buffer view holds zeros; at most 2^24 of them are
// granted, since no byte of the file pays for them. Throws GltfFailure: invalid_file, and what
// GltfBuffers::view throws.
std::vector<Position> read_positions(const GltfDocument& document, GltfBuffers& buffers, uint32_t accessor);

// Also refuses the largest value of the type, which other formats use to restart a strip.
std::vector<uint32_t> read_indices(const GltfDocument& document, GltfBuffers& buffers, uint32_t accessor);

// The value of an integer component in float arithmetic: c, or when normalized c / max, not below -1.
float dequantize(float component, GltfElementType type);

}  // namespace vcd::baker
