#include "ingest/gltf_meshopt.h"

#include <meshoptimizer.h>

#include <string>

namespace vcd::baker {

namespace {

// First byte of each stream: codec in the high half, version in the low half.
constexpr uint8_t newest_vertex_header = 0xA0;

struct Compressed {
  std::string mode;
  std::string filter;
  uint64_t count = 0;
  uint64_t stride = 0;
  std::span<const uint8_t> bytes;
};

[[noreturn]] void fail_unknown(const GltfElement<tinygltf::Value>& extension, const std::string& what) {
  fail_gltf(ErrorCode::unsupported, extension.place + ": " + what + " is not known");
}

// The fewest bytes that can hold so many elements: the vertex codec spends 2 bits on 16 bytes of one channel,
// the index codec a byte on a triangle, the sequence codec a byte on an index.
bool fits(const Compressed& c) {
  const uint64_t size = c.bytes.size();
  if (c.mode == "ATTRIBUTES") return c.count <= size * 64 / c.stride;
  if (c.mode == "TRIANGLES") return c.count / 3 <= size;
  return c.count <= size;
}

void check_layout(const GltfElement<tinygltf::Value>& extension, const Compressed& c) {
  const bool attributes = c.mode == "ATTRIBUTES";
  if (!attributes && c.mode != "TRIANGLES" && c.mode != "INDICES") {
    fail_unknown(extension, "mode " + quoted(c.mode));
  }
  const bool stride_ok =
      attributes ? c.stride >= 4 && c.stride <= 256 && c.stride % 4 == 0 : c.stride == 2 || c.stride == 4;
  if (!stride_ok) extension.fail("byteStride " + std::to_string(c.stride) + " is not allowed in mode " + c.mode);
  if (c.count == 0) extension.fail("count is 0");
  if (c.mode == "TRIANGLES" && c.count % 3 != 0) extension.fail("count is not a multiple of 3");
  if (!fits(c)) {
    extension.fail(std::to_string(c.bytes.size()) + " bytes cannot hold " + std::to_string(c.count) + " elements");
  }
  if (c.filter == "NONE") return;
  if (!attributes) extension.fail("a filter is allowed in mode ATTRIBUTES only");
  if (c.filter == "OCTAHEDRAL") {
    if (c.stride != 4 && c.stride != 8) extension.fail("filter OCTAHEDRAL needs a byteStride of 4 or 8");
  } else if (c.filter == "QUATERNION") {
    if (c.stride != 8) extension.fail("filter QUATERNION needs a byteStride of 8");
  } else if (c.filter != "EXPONENTIAL") {
    fail_unknown(extension, "filter " + quoted(c.filter));
  }
}

int decode(const Compressed& c, std::vector<uint8_t>& out) {
  if (c.mode == "ATTRIBUTES") {
    return meshopt_decodeVertexBuffer(out.data(), c.count, c.stride, c.bytes.data(), c.bytes.size());
  }
  if (c.mode == "TRIANGLES") {
    return meshopt_decodeIndexBuffer(out.data(), c.count, c.stride, c.bytes.data(), c.bytes.size());
  }
  return meshopt_decodeIndexSequence(out.data(), c.count, c.stride, c.bytes.data(), c.bytes.size());
}

void undo_filter(const Compressed& c, std::vector<uint8_t>& bytes) {
  if (c.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(bytes.data(), c.count, c.stride);
  if (c.filter == "QUATERNION") meshopt_decodeFilterQuat(bytes.data(), c.count, c.stride);
  if (c.filter == "EXPONENTIAL") meshopt_decodeFilterExp(bytes.data(), c.count, c.stride);
}

}  // namespace

std::vector<uint8_t> decode_meshopt(const GltfElement<tinygltf::Value>& extension,
                                    std::span<const uint8_t> compressed) {
  const std::string& filter = extension->Get("filter").Get<std::string>();
  const Compressed c = {extension->Get("mode").Get<std::string>(), filter.empty() ? "NONE" : filter,
                        number_in(*extension.object, "count"), number_in(*extension.object, "byteStride"), compressed};
  check_layout(extension, c);
  const bool newer = c.mode == "ATTRIBUTES" && (compressed[0] & 0xF0) == 0xA0 && compressed[0] > newest_vertex_header;
  if (newer) fail_unknown(extension, "version " + std::to_string(compressed[0] & 0x0F) + " of the vertex codec");
  std::vector<uint8_t> bytes(c.count * c.stride);
  if (decode(c, bytes) != 0) extension.fail("the compressed data is corrupt");
  undo_filter(c, bytes);
  return bytes;
}

}  // namespace vcd::baker
