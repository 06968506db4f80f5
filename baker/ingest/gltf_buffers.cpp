#include "ingest/gltf_buffers.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "ingest/gltf_meshopt.h"
#include "ingest/gltf_uri.h"
#include "ingest/what_else.h"

namespace vcd::baker {

namespace {

std::optional<GltfObject> compression_of(const GltfObject& view) {
  std::optional<GltfObject> extension = view.extension("EXT_meshopt_compression");
  return extension ? extension : view.extension("KHR_meshopt_compression");
}

std::optional<uint32_t> stride_of(const GltfObject& view) {
  if (!view.has("byteStride")) return std::nullopt;
  const uint64_t stride = view.integer("byteStride");
  if (stride == 0) return std::nullopt;  // not allowed, but written for "no gaps", as other formats have it
  if (stride > 252) view.fail("byteStride " + std::to_string(stride) + " is more than 252");
  return static_cast<uint32_t>(stride);
}

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
  const GltfObject view = document_.element("bufferViews", index);
  const std::optional<GltfObject> extension = compression_of(view);
  return {extension ? decompressed(index, view, *extension) : range(view), stride_of(view)};
}

std::span<const uint8_t> GltfBuffers::decompressed(uint32_t index, const GltfObject& view,
                                                   const GltfObject& extension) {
  const auto known = decompressed_.find(index);
  if (known != decompressed_.end()) return known->second;
  std::vector<uint8_t> bytes = decode_meshopt(extension, range(extension));
  if (bytes.size() != view.integer("byteLength")) {
    view.fail("byteLength " + std::to_string(view.integer("byteLength")) + " differs from the " +
              std::to_string(bytes.size()) + " bytes that it decompresses to");
  }
  return decompressed_.emplace(index, std::move(bytes)).first->second;
}

std::span<const uint8_t> GltfBuffers::range(const GltfObject& holder) {
  const std::span<const uint8_t> bytes = buffer(holder.required_index("buffer"));
  const uint64_t offset = holder.integer_or("byteOffset", 0);
  const uint64_t length = holder.integer("byteLength");
  if (length == 0) holder.fail("byteLength is 0");
  if (offset > bytes.size() || length > bytes.size() - offset) {
    holder.fail("byteOffset " + std::to_string(offset) + " and byteLength " + std::to_string(length) + " exceed the " +
                std::to_string(bytes.size()) + " bytes of the buffer");
  }
  return bytes.subspan(offset, length);
}

std::span<const uint8_t> GltfBuffers::buffer(uint32_t index) {
  const GltfObject buffer = document_.element("buffers", index);
  const uint64_t length = buffer.integer("byteLength");
  const std::string uri = buffer.text_or("uri", "");
  std::span<const uint8_t> bytes;
  if (!uri.empty()) {
    auto known = loaded_.find(index);
    if (known == loaded_.end()) known = loaded_.emplace(index, load_from_uri(buffer, uri)).first;
    bytes = as_bytes(known->second);
  } else if (index == 0 && document_.is_binary()) {
    bytes = document_.binary_chunk();
  } else {
    // Allowed by the specification: the data comes by another way, which no file can tell.
    fail_gltf(ErrorCode::io, buffer.place() + ": has no uri, its data is missing");
  }
  if (length > bytes.size()) {
    const char* what = uri.empty() ? nullptr : what_else({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (what != nullptr) buffer.fail("the file " + quoted(uri) + " " + what);
    buffer.fail("byteLength is " + std::to_string(length) + ", the data has " + std::to_string(bytes.size()));
  }
  return bytes.first(length);
}

std::string GltfBuffers::load_from_uri(const GltfObject& buffer, const std::string& uri) {
  if (is_data_uri(uri)) return decode_data_uri(uri);
  if (has_scheme(uri)) {
    fail_gltf(ErrorCode::unsupported, buffer.place() + ": the uri " + quoted(uri) + " is not relative to the file");
  }
  const std::string name = percent_decode(uri);
  if (name.find('\0') != std::string::npos) buffer.fail("the uri holds a zero byte");
  if (!files_outside_ && leads_outside(document_.folder(), name)) {
    fail_gltf(ErrorCode::unsupported, buffer.place() + ": the uri " + quoted(uri) +
                                          " leads out of the file's folder; that is read only where outside files "
                                          "are allowed (--allow-outside-files)");
  }
  Result<std::string> bytes = read_file(document_.folder() / name);
  if (!bytes) fail_gltf(bytes.error().code, bytes.error().message);
  files_.push_back({name, content_hash(*bytes)});
  return *std::move(bytes);
}

}  // namespace vcd::baker
