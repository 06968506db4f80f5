#include "ingest/gltf_buffers.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "ingest/gltf_meshopt.h"
#include "ingest/gltf_uri.h"
#include "ingest/what_else.h"

namespace vcd::baker {

namespace {

// Whether a relative name means a file elsewhere than below the folder, by itself or by a link on its way. A file that
// does not exist is judged by its name.
bool leads_outside(const std::filesystem::path& folder, const std::filesystem::path& name) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path root = fs::canonical(folder.empty() ? "." : folder, error);
  const fs::path file = error ? fs::path() : fs::weakly_canonical(root / name, error);
  if (error) return true;
  return std::mismatch(root.begin(), root.end(), file.begin(), file.end()).first != root.end();
}

}  // namespace

GltfView GltfBuffers::view(uint32_t index) {
  const auto view = document_.view(index);
  GltfView result;
  // 0 is not allowed, but written for "no gaps", as other formats have it.
  if (const size_t stride = view->byteStride; stride > 252)
    view.fail("byteStride " + std::to_string(stride) + " is more than 252");
  else if (stride > 0) result.stride = static_cast<uint32_t>(stride);
  auto extension = extension_of(view, "EXT_meshopt_compression");
  if (!extension) extension = extension_of(view, "KHR_meshopt_compression");
  result.bytes = extension ? decompressed(index, view, *extension)
                           : range(static_cast<uint32_t>(view->buffer), view->byteOffset, view->byteLength, view.place);
  return result;
}

std::span<const uint8_t> GltfBuffers::decompressed(uint32_t index, const GltfElement<tinygltf::BufferView>& view,
                                                   const GltfElement<tinygltf::Value>& extension) {
  const auto known = decompressed_.find(index);
  if (known != decompressed_.end()) return known->second;
  const tinygltf::Value& of = *extension.object;
  std::vector<uint8_t> bytes = decode_meshopt(extension, range(number_in(of, "buffer"), number_in(of, "byteOffset"),
                                                               number_in(of, "byteLength"), extension.place));
  if (bytes.size() != view->byteLength) {
    view.fail("byteLength " + std::to_string(view->byteLength) + " differs from the " + std::to_string(bytes.size()) +
              " bytes that it decompresses to");
  }
  return decompressed_.emplace(index, std::move(bytes)).first->second;
}

std::span<const uint8_t> GltfBuffers::range(uint32_t index, uint64_t offset, uint64_t length,
                                            const std::string& place) {
  const std::span<const uint8_t> bytes = buffer(index);
  if (length == 0) fail_invalid(place + ": byteLength is 0");
  if (offset > bytes.size() || length > bytes.size() - offset) {
    fail_invalid(place + ": byteOffset " + std::to_string(offset) + " and byteLength " + std::to_string(length) +
                 " exceed the " + std::to_string(bytes.size()) + " bytes of the buffer");
  }
  return bytes.subspan(offset, length);
}

std::span<const uint8_t> GltfBuffers::buffer(uint32_t index) {
  const auto buffer = document_.buffer(index);
  const std::string& uri = buffer->uri;
  std::span<const uint8_t> bytes;
  if (!uri.empty()) {
    auto known = loaded_.find(index);
    if (known == loaded_.end()) known = loaded_.emplace(index, load_from_uri(buffer)).first;
    bytes = as_bytes(known->second);
  } else if (index == 0 && document_.is_binary()) {
    bytes = document_.binary_chunk();
  } else {
    // Allowed by the specification: the data comes by another way, which no file can tell.
    fail_gltf(ErrorCode::io, buffer.place + ": has no uri, its data is missing");
  }
  if (buffer->byte_length > bytes.size()) {
    const char* what = uri.empty() ? nullptr : what_else({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (what != nullptr) buffer.fail("the file " + quoted(uri) + " " + what);
    buffer.fail("byteLength is " + std::to_string(buffer->byte_length) + ", the data has " +
                std::to_string(bytes.size()));
  }
  return bytes.first(buffer->byte_length);
}

std::string GltfBuffers::load_from_uri(const GltfElement<GltfBufferSource>& buffer) {
  const std::string& uri = buffer->uri;
  if (is_data_uri(uri)) return decode_data_uri(uri);
  if (has_scheme(uri)) {
    fail_gltf(ErrorCode::unsupported, buffer.place + ": the uri " + quoted(uri) + " is not relative to the file");
  }
  const std::string name = percent_decode(uri);
  if (name.find('\0') != std::string::npos) buffer.fail("the uri holds a zero byte");
  if (!files_outside_ && leads_outside(document_.folder(), name)) {
    fail_gltf(ErrorCode::unsupported, buffer.place + ": the uri " + quoted(uri) +
                                          " leads out of the file's folder; that is read only where outside files "
                                          "are allowed (--allow-outside-files)");
  }
  Result<std::string> bytes = read_file(document_.folder() / name);
  if (!bytes) fail_gltf(bytes.error().code, bytes.error().message);
  files_.push_back({name, content_hash(*bytes)});
  return *std::move(bytes);
}

}  // namespace vcd::baker
