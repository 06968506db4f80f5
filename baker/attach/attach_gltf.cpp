#include "attach_gltf.h"

#include <algorithm>
#include <cstdint>

#include "attach/json_text.h"
#include "ingest/gltf_document.h"

namespace vcd::baker {
namespace {

constexpr size_t kJsonBegin = 20;         // in GLB: behind the file's header and the first chunk's
constexpr size_t kChunkHeader = 8;        // length, type
constexpr size_t kSidecarAlignment = 64;  // that Sidecar::open_buffer() needs to use all in place

std::string_view text_of(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void pad(std::string& bytes, size_t begin, size_t alignment, char with) {
  while ((begin + bytes.size()) % alignment != 0) bytes += with;
}

std::string base64(Bytes bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    const size_t count = std::min<size_t>(3, bytes.size() - i);
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < count ? std::to_integer<uint32_t>(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

class GltfAttaching {
 public:
  GltfAttaching(const std::filesystem::path& path, std::string_view bytes, const Attachment& attachment)
      : attachment_(attachment),
        document_(path, bytes),
        container_(split_gltf(as_bytes(bytes))),
        json_(text_of(container_.json)),
        binary_(text_of(container_.binary)) {
    document_.check("/extensionsUsed");
    if (document_.uses_extension(std::string(kAttachedName))) fail_has_one();
  }

  std::string run() {
    if (!attachment_.embedded.empty()) embed();
    for (const Attachment::Mesh& mesh : attachment_.meshes) mark(mesh);
    add_to_array("extensionsUsed", json_string(kAttachedName));
    return document_.is_binary() ? glb() : json_.edited();
  }

 private:
  // To an array of the root, which it may lack.
  void add_to_array(std::string_view key, const std::string& json) {
    const auto array = json_.member(json_.root(), key);
    if (!array) return json_.add_member(json_.root(), key, joined({"[", json, "]"}));
    if (json_.text_of(*array) == "null") return json_.replace(*array, joined({"[", json, "]"}));
    json_.add_element(*array, json);
  }

  void mark(const Attachment::Mesh& mesh) {
    const std::string of = document_.mesh(mesh.source_index).place;
    const std::string where = attachment_.embedded.empty()
                                  ? joined({"\"uri\":", json_string(attachment_.uri)})
                                  : joined({"\"bufferView\":", std::to_string(document_.model().bufferViews.size())});
    const std::string value = joined({"{", where, ",\"geometryHash\":", json_string(hex_of(mesh.geometry_hash)), "}"});
    const auto place = json_.elements(*json_.member(json_.root(), "meshes"))[mesh.source_index];
    const std::string extensions = joined({"{", json_string(kAttachedName), ":", value, "}"});
    const auto known = json_.member(place, "extensions");
    if (!known) return json_.add_member(place, "extensions", extensions);
    if (json_.text_of(*known) == "null") return json_.replace(*known, extensions);
    if (json_.text_of(*known).front() != '{') fail_invalid(of + ", extensions: is not a JSON object");
    if (json_.member(*known, kAttachedName)) fail_has_one();  // although extensionsUsed does not say so
    json_.add_member(*known, kAttachedName, value);
  }

  // A buffer without a uri may also be a fallback that lies nowhere.
  bool is_binary_chunk(const GltfBufferSource& buffer) const {
    return buffer.uri.empty() && buffer.byte_length <= binary_.size();
  }

  // As a buffer view: of the binary chunk where that is a buffer or can be one, else of a buffer of its own.
  void embed() {
    const Bytes sidecar = attachment_.embedded;
    const size_t buffers = document_.model().buffers.size();
    size_t buffer = 0, offset = 0;
    if (document_.is_binary() && (buffers == 0 || is_binary_chunk(*document_.buffer(0).object))) {
      pad(binary_, 0, kSidecarAlignment, '\0');
      offset = binary_.size();
      binary_.append(reinterpret_cast<const char*>(sidecar.data()), sidecar.size());
      const std::string length = std::to_string(binary_.size());
      if (buffers == 0) add_to_array("buffers", joined({"{\"byteLength\":", length, "}"}));
      else
        json_.replace(*json_.member(json_.elements(*json_.member(json_.root(), "buffers"))[0], "byteLength"), length);
      align_binary_ = true;
    } else {
      buffer = buffers;
      add_to_array("buffers", joined({"{\"byteLength\":", std::to_string(sidecar.size()),
                                      ",\"uri\":\"data:application/octet-stream;base64,", base64(sidecar), "\"}"}));
    }
    document_.check("/bufferViews");
    add_to_array("bufferViews",
                 joined({"{\"buffer\":", std::to_string(buffer), ",\"byteOffset\":", std::to_string(offset),
                         ",\"byteLength\":", std::to_string(sidecar.size()), "}"}));
  }

  std::string glb() {
    std::string json = json_.edited();
    pad(json, align_binary_ ? kJsonBegin + kChunkHeader : 0, align_binary_ ? kSidecarAlignment : 4, ' ');
    std::string file = "glTF";
    const auto number = [&](uint64_t value) {
      if (value > UINT32_MAX) fail_gltf(ErrorCode::unsupported, "with its sidecar it would be larger than 4 GiB");
      for (int shift = 0; shift < 32; shift += 8) file += static_cast<char>(value >> shift & 0xFF);
    };
    pad(binary_, 0, 4, '\0');
    const std::string_view others = text_of(container_.others);
    number(2);
    number(kJsonBegin + json.size() + (binary_.empty() ? 0 : kChunkHeader + binary_.size()) + others.size());
    number(json.size());
    file += joined({"JSON", json});
    if (!binary_.empty()) {
      number(binary_.size());
      file += joined({std::string_view("BIN\0", 4), binary_});
    }
    return file.append(others);
  }

  const Attachment& attachment_;
  GltfDocument document_;
  GltfContainer container_;
  JsonText json_;
  std::string binary_;
  bool align_binary_ = false;
};

}  // namespace

std::string attach_gltf(const std::filesystem::path& path, std::string_view bytes, const Attachment& attachment) {
  return GltfAttaching(path, bytes, attachment).run();
}

}  // namespace vcd::baker
