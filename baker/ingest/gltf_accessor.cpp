#include "ingest/gltf_accessor.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace vcd::baker {

namespace {

constexpr uint64_t most_unbacked_elements = uint64_t{1} << 24;

struct Accessor {
  GltfElement<tinygltf::Accessor> element;
  GltfElementType type;
  uint32_t component_size = 0;
  uint32_t element_size = 0;
  uint64_t count = 0;
};

uint32_t size_of(int component) {
  return static_cast<uint32_t>(tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(component)));
}

Accessor accessor_of(const GltfDocument& document, uint32_t index, uint32_t component_count) {
  const auto element = document.accessor(index);
  const GltfElementType type = {element->componentType, element->normalized};
  return {element, type, size_of(type.component), size_of(type.component) * component_count, element->count};
}

Accessor position_accessor(const GltfDocument& document, uint32_t index) {
  const Accessor accessor = accessor_of(document, index, 3);
  const auto& element = accessor.element;
  if (element->type != TINYGLTF_TYPE_VEC3) element.fail("positions must be VEC3");
  if (accessor.type.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
    element.fail("positions cannot be 32-bit integers");
  if (accessor.type.component == TINYGLTF_COMPONENT_TYPE_FLOAT) {
    if (accessor.type.normalized) element.fail("float components cannot be normalized");
  } else if (!document.uses_extension("KHR_mesh_quantization")) {
    element.fail("integer positions need the extension KHR_mesh_quantization, which the file does not list");
  }
  return accessor;
}

Accessor index_accessor(const GltfDocument& document, uint32_t index) {
  const Accessor accessor = accessor_of(document, index, 1);
  const auto& element = accessor.element;
  if (element->type != TINYGLTF_TYPE_SCALAR) element.fail("indices must be SCALAR");
  const int component = accessor.type.component;
  const bool is_unsigned = component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                           component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                           component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  if (!is_unsigned) element.fail("indices must be unsigned integers");
  if (accessor.type.normalized) element.fail("indices cannot be normalized");
  return accessor;
}

struct Layout {
  uint64_t offset = 0;
  uint64_t stride = 0;
  uint64_t element_size = 0;
  uint32_t component_size = 0;
  uint64_t count = 0;
};

// Copies the elements of a view into one dense array.
std::vector<uint8_t> gather(const GltfElement<tinygltf::Accessor>& holder, std::span<const uint8_t> bytes,
                            const Layout& layout) {
  if (layout.offset % layout.component_size != 0) holder.fail("byteOffset is not aligned to the component size");
  if (layout.stride < layout.element_size) {
    holder.fail("byteStride " + std::to_string(layout.stride) + " is less than one element");
  }
  const bool one_fits = bytes.size() >= layout.element_size && layout.offset <= bytes.size() - layout.element_size;
  const uint64_t room = one_fits ? (bytes.size() - layout.element_size - layout.offset) / layout.stride + 1 : 0;
  if (layout.count > room) {
    holder.fail(std::to_string(layout.count) + " elements exceed the buffer view of " + std::to_string(bytes.size()) +
                " bytes, which has room for " + std::to_string(room));
  }
  std::vector<uint8_t> dense(layout.count * layout.element_size);
  for (uint64_t i = 0; i < layout.count; ++i) {
    std::memcpy(dense.data() + i * layout.element_size, bytes.data() + layout.offset + i * layout.stride,
                layout.element_size);
  }
  return dense;
}

// Indices and the two arrays of a sparse accessor are always packed.
std::span<const uint8_t> packed_view(GltfBuffers& buffers, const GltfElement<tinygltf::Accessor>& holder, int index) {
  const GltfView view = buffers.view(static_cast<uint32_t>(index));
  if (view.stride) holder.fail("its buffer view must not have a byteStride");
  return view.bytes;
}

uint32_t index_at(const std::vector<uint8_t>& dense, uint64_t i, uint32_t size) {
  uint32_t value = 0;  // little-endian, so the low bytes come first
  std::memcpy(&value, dense.data() + i * size, size);
  return value;
}

void apply_sparse(GltfBuffers& buffers, const Accessor& accessor, std::vector<uint8_t>& dense) {
  const auto& sparse = accessor.element->sparse;
  const auto part = [&](const char* name) {
    return GltfElement<tinygltf::Accessor>{accessor.element.object, accessor.element.place + ", sparse" + name};
  };
  const auto indices = part(", indices"), values = part(", values");
  const auto count = static_cast<uint32_t>(sparse.count);
  if (count == 0 || count > accessor.count) part("").fail("count must lie between 1 and the accessor's count");
  const uint32_t index_size = size_of(sparse.indices.componentType);
  const std::vector<uint8_t> places =
      gather(indices, packed_view(buffers, indices, sparse.indices.bufferView),
             {static_cast<uint32_t>(sparse.indices.byteOffset), index_size, index_size, index_size, count});
  const std::vector<uint8_t> substitutes =
      gather(values, packed_view(buffers, values, sparse.values.bufferView),
             {static_cast<uint32_t>(sparse.values.byteOffset), accessor.element_size, accessor.element_size,
              accessor.component_size, count});
  uint64_t next_allowed = 0;
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t place = index_at(places, i, index_size);
    if (place < next_allowed) indices.fail("element " + std::to_string(i) + " does not increase");
    if (place >= accessor.count) indices.fail("element " + std::to_string(i) + " exceeds the accessor's count");
    next_allowed = place + 1;
    std::memcpy(dense.data() + place * accessor.element_size, substitutes.data() + i * accessor.element_size,
                accessor.element_size);
  }
}

std::vector<uint8_t> read_elements(GltfBuffers& buffers, const Accessor& accessor, bool may_interleave) {
  const auto& element = accessor.element;
  std::vector<uint8_t> dense;
  if (element->bufferView >= 0) {
    const GltfView view = buffers.view(static_cast<uint32_t>(element->bufferView));
    // For indices it is not allowed, and taken where it says what holds anyway, or where its meaning is plain.
    const bool plain = view.stride && *view.stride % 4 == 0;
    if (view.stride && !plain && (may_interleave || *view.stride != accessor.element_size))
      element.fail("byteStride " + std::to_string(*view.stride) + " is not a multiple of 4 from 4 to 252");
    dense = gather(element, view.bytes,
                   {element->byteOffset, view.stride.value_or(accessor.element_size), accessor.element_size,
                    accessor.component_size, accessor.count});
  } else {
    if (accessor.count > most_unbacked_elements) element.fail("has no buffer view for its many elements");
    dense.resize(accessor.count * accessor.element_size);
  }
  if (element->sparse.isSparse) apply_sparse(buffers, accessor, dense);
  return dense;
}

template <class Component>
float component_at(const uint8_t* bytes) {
  Component value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<float>(value);
}

float component_value(const uint8_t* bytes, GltfElementType type) {
  switch (type.component) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return dequantize(component_at<int8_t>(bytes), type);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return dequantize(component_at<uint8_t>(bytes), type);
    case TINYGLTF_COMPONENT_TYPE_SHORT: return dequantize(component_at<int16_t>(bytes), type);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return dequantize(component_at<uint16_t>(bytes), type);
    default: return component_at<float>(bytes);
  }
}

}  // namespace

float dequantize(float component, GltfElementType type) {
  if (!type.normalized) return component;
  switch (type.component) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return std::max(component / 127.0f, -1.0f);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return component / 255.0f;
    case TINYGLTF_COMPONENT_TYPE_SHORT: return std::max(component / 32767.0f, -1.0f);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return component / 65535.0f;
    default: return component;
  }
}

GltfPositionAccessor check_position_accessor(const GltfDocument& document, uint32_t accessor) {
  const Accessor checked = position_accessor(document, accessor);
  return {checked.type, checked.count};
}

bool is_empty_accessor(const GltfDocument& document, uint32_t accessor) {
  return document.accessor(accessor)->count == 0;
}

uint64_t check_index_accessor(const GltfDocument& document, uint32_t accessor) {
  return index_accessor(document, accessor).count;
}

std::vector<Position> read_positions(const GltfDocument& document, GltfBuffers& buffers, uint32_t accessor) {
  const Accessor source = position_accessor(document, accessor);
  const std::vector<uint8_t> dense = read_elements(buffers, source, /*may_interleave=*/true);
  std::vector<Position> positions(source.count);
  const uint8_t* bytes = dense.data();
  for (Position& position : positions) {
    for (float& coordinate : position) {
      coordinate = component_value(bytes, source.type);
      bytes += source.component_size;
    }
  }
  return positions;
}

std::vector<uint32_t> read_indices(const GltfDocument& document, GltfBuffers& buffers, uint32_t accessor) {
  const Accessor source = index_accessor(document, accessor);
  const std::vector<uint8_t> dense = read_elements(buffers, source, /*may_interleave=*/false);
  const uint32_t restart = UINT32_MAX >> (32 - 8 * source.component_size);
  std::vector<uint32_t> indices(source.count);
  for (uint64_t i = 0; i < source.count; ++i) {
    indices[i] = index_at(dense, i, source.component_size);
    if (indices[i] == restart) {
      source.element.fail("index element " + std::to_string(i) + " is " + std::to_string(restart) +
                          ", the primitive restart value");
    }
  }
  return indices;
}

}  // namespace vcd::baker
