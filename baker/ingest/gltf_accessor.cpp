#include "ingest/gltf_accessor.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace vcd::baker {

namespace {

constexpr uint64_t most_unbacked_elements = uint64_t{1} << 24;

struct Accessor {
  GltfObject object;
  GltfElementType type;
  uint32_t component_size = 0;
  uint32_t element_size = 0;
  uint64_t count = 0;
};

uint32_t size_of(GltfComponent component) {
  switch (component) {
    case GltfComponent::int8:
    case GltfComponent::uint8: return 1;
    case GltfComponent::int16:
    case GltfComponent::uint16: return 2;
    case GltfComponent::uint32:
    case GltfComponent::float32: return 4;
  }
  return 0;  // not one of glTF's
}

Accessor accessor_of(const GltfDocument& document, uint32_t index, uint32_t component_count) {
  const GltfObject object = document.element("accessors", index);
  Accessor accessor{object, {}, 0, 0, 0};
  const uint64_t component = object.integer("componentType");
  accessor.type = {static_cast<GltfComponent>(std::min<uint64_t>(component, UINT32_MAX)), object.flag("normalized")};
  accessor.component_size = size_of(accessor.type.component);
  if (accessor.component_size == 0) object.fail("componentType " + std::to_string(component) + " does not exist");
  accessor.element_size = accessor.component_size * component_count;
  accessor.count = object.integer("count");
  return accessor;
}

Accessor position_accessor(const GltfDocument& document, uint32_t index) {
  const Accessor accessor = accessor_of(document, index, 3);
  const std::string type = accessor.object.text_or("type", "");
  if (type != "VEC3") accessor.object.fail("positions must be VEC3, not " + quoted(type));
  if (accessor.type.component == GltfComponent::uint32) accessor.object.fail("positions cannot be 32-bit integers");
  if (accessor.type.component == GltfComponent::float32) {
    if (accessor.type.normalized) accessor.object.fail("float components cannot be normalized");
  } else if (!document.uses_extension("KHR_mesh_quantization")) {
    accessor.object.fail("integer positions need the extension KHR_mesh_quantization, which the file does not list");
  }
  return accessor;
}

Accessor index_accessor(const GltfDocument& document, uint32_t index) {
  const Accessor accessor = accessor_of(document, index, 1);
  const std::string type = accessor.object.text_or("type", "");
  if (type != "SCALAR") accessor.object.fail("indices must be SCALAR, not " + quoted(type));
  const GltfComponent component = accessor.type.component;
  const bool is_unsigned =
      component == GltfComponent::uint8 || component == GltfComponent::uint16 || component == GltfComponent::uint32;
  if (!is_unsigned) accessor.object.fail("indices must be unsigned integers");
  if (accessor.type.normalized) accessor.object.fail("indices cannot be normalized");
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
std::vector<uint8_t> gather(const GltfObject& holder, std::span<const uint8_t> bytes, const Layout& layout) {
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
std::span<const uint8_t> packed_view(GltfBuffers& buffers, const GltfObject& holder) {
  const GltfView view = buffers.view(holder.required_index("bufferView"));
  if (view.stride) holder.fail("its buffer view must not have a byteStride");
  return view.bytes;
}

uint32_t index_at(const std::vector<uint8_t>& dense, uint64_t i, uint32_t size) {
  uint32_t value = 0;  // little-endian, so the low bytes come first
  std::memcpy(&value, dense.data() + i * size, size);
  return value;
}

void apply_sparse(GltfBuffers& buffers, const Accessor& accessor, const GltfObject& sparse,
                  std::vector<uint8_t>& dense) {
  const uint64_t count = sparse.integer("count");
  if (count == 0 || count > accessor.count) sparse.fail("count must lie between 1 and the accessor's count");
  const GltfObject indices = sparse.required_object("indices");
  const GltfObject values = sparse.required_object("values");
  const uint64_t component = indices.integer("componentType");
  const bool is_unsigned = component == 5121 || component == 5123 || component == 5125;
  if (!is_unsigned) indices.fail("componentType must be that of an unsigned integer");
  const uint32_t index_size = size_of(static_cast<GltfComponent>(component));
  const std::vector<uint8_t> places =
      gather(indices, packed_view(buffers, indices),
             {indices.integer_or("byteOffset", 0), index_size, index_size, index_size, count});
  const std::vector<uint8_t> substitutes = gather(values, packed_view(buffers, values),
                                                  {values.integer_or("byteOffset", 0), accessor.element_size,
                                                   accessor.element_size, accessor.component_size, count});
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
  const GltfObject& object = accessor.object;
  std::vector<uint8_t> dense;
  if (const std::optional<uint32_t> view_index = object.index("bufferView")) {
    const GltfView view = buffers.view(*view_index);
    // For indices it is not allowed, and taken where it says what holds anyway, or where its meaning is plain.
    const bool plain = view.stride && *view.stride % 4 == 0;
    if (view.stride && !plain && (may_interleave || *view.stride != accessor.element_size))
      object.fail("byteStride " + std::to_string(*view.stride) + " is not a multiple of 4 from 4 to 252");
    dense = gather(object, view.bytes,
                   {object.integer_or("byteOffset", 0), view.stride.value_or(accessor.element_size),
                    accessor.element_size, accessor.component_size, accessor.count});
  } else {
    if (accessor.count > most_unbacked_elements) object.fail("has no buffer view for its many elements");
    dense.resize(accessor.count * accessor.element_size);
  }
  if (const std::optional<GltfObject> sparse = object.object("sparse")) apply_sparse(buffers, accessor, *sparse, dense);
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
    case GltfComponent::int8: return dequantize(component_at<int8_t>(bytes), type);
    case GltfComponent::uint8: return dequantize(component_at<uint8_t>(bytes), type);
    case GltfComponent::int16: return dequantize(component_at<int16_t>(bytes), type);
    case GltfComponent::uint16: return dequantize(component_at<uint16_t>(bytes), type);
    default: return component_at<float>(bytes);
  }
}

}  // namespace

float dequantize(float component, GltfElementType type) {
  if (!type.normalized) return component;
  switch (type.component) {
    case GltfComponent::int8: return std::max(component / 127.0f, -1.0f);
    case GltfComponent::uint8: return component / 255.0f;
    case GltfComponent::int16: return std::max(component / 32767.0f, -1.0f);
    case GltfComponent::uint16: return component / 65535.0f;
    default: return component;
  }
}

GltfPositionAccessor check_position_accessor(const GltfDocument& document, uint32_t accessor) {
  const Accessor checked = position_accessor(document, accessor);
  return {checked.type, checked.count};
}

bool is_empty_accessor(const GltfDocument& document, uint32_t accessor) {
  return document.element("accessors", accessor).integer("count") == 0;
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
      source.object.fail("index element " + std::to_string(i) + " is " + std::to_string(restart) +
                         ", the primitive restart value");
    }
  }
  return indices;
}

}  // namespace vcd::baker
