#include "ingest/gltf_document.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <utility>

#include "ingest/gltf_extensions.h"

namespace vcd::baker {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "glTF's binary data is little-endian");

namespace {

constexpr uint32_t glb_magic = 0x46546C67;          // "glTF"
constexpr uint32_t json_chunk_type = 0x4E4F534A;    // "JSON"
constexpr uint32_t binary_chunk_type = 0x004E4942;  // "BIN\0"
constexpr size_t glb_header_size = 12;              // magic, version, length
constexpr size_t chunk_header_size = 8;             // length, type

uint32_t read_u32(std::span<const uint8_t> bytes, size_t offset) {
  uint32_t value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

// JSON must come first, the binary chunk may come second; chunks of other types are passed over, as the
// specification asks. Bytes behind the declared length are passed over too.
GltfContainer split_glb(std::span<const uint8_t> file) {
  if (file.size() < glb_header_size) fail_invalid("truncated GLB: shorter than its 12-byte header");
  const uint32_t version = read_u32(file, 4);
  if (version == 1) fail_gltf(ErrorCode::unsupported, "glTF 1.0 (GLB version 1) is not supported, convert it to 2.0");
  if (version != 2) fail_gltf(ErrorCode::unsupported, "GLB version " + std::to_string(version) + " is not supported");
  const size_t length = read_u32(file, 8);
  if (length > file.size()) {
    fail_invalid("truncated GLB: declares " + std::to_string(length) + " bytes, has " + std::to_string(file.size()));
  }
  GltfContainer chunks{.is_binary = true, .json = {}, .binary = {}, .others = {}};
  size_t number = 0;
  for (size_t offset = glb_header_size; offset < length; ++number) {
    if (length - offset < chunk_header_size) fail_invalid("GLB chunk " + std::to_string(number) + ": truncated header");
    const size_t size = read_u32(file, offset);
    const uint32_t type = read_u32(file, offset + 4);
    offset += chunk_header_size;
    if (size > length - offset) {
      fail_invalid("GLB chunk " + std::to_string(number) + ": declares " + std::to_string(size) + " bytes, " +
                   std::to_string(length - offset) + " are left");
    }
    if ((type == json_chunk_type) != (number == 0)) fail_invalid("GLB: the JSON chunk must come first, and once");
    if (type == binary_chunk_type && number != 1) fail_invalid("GLB: the binary chunk must come second, and once");
    if (type == json_chunk_type) chunks.json = file.subspan(offset, size);
    if (type == binary_chunk_type) chunks.binary = file.subspan(offset, size);
    offset += size;
    if (number == 0 || type == binary_chunk_type) chunks.others = file.subspan(offset, length - offset);
  }
  if (number == 0) fail_invalid("GLB without a JSON chunk");
  return chunks;
}

// "line 3, column 7: ", both counted from 1; columns are bytes.
std::string place_in(std::span<const uint8_t> text, size_t bytes_read) {
  const auto before = text.first(std::min(bytes_read > 0 ? bytes_read - 1 : 0, text.size()));
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const auto column = std::find(before.rbegin(), before.rend(), '\n') - before.rbegin() + 1;
  return "line " + std::to_string(line) + ", column " + std::to_string(column) + ": ";
}

// Of "[json.exception.parse_error.101] parse error at line 1, column 2: reason; last read: …" the reason.
std::string reason_of(const std::string& what) {
  size_t begin = what.find("column ");
  begin = begin == std::string::npos ? what.find("] ") : what.find(": ", begin);
  std::string reason = begin == std::string::npos ? what : what.substr(begin + 2);
  for (char& c : reason)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7E) c = '?';
  return reason;
}

struct Version {
  int major = 0;
  int minor = 0;
  auto operator<=>(const Version&) const = default;
};

Version parse_version(const std::string& text, const char* what) {
  Version version;
  int end = 0;
  const bool parsed =
      text.size() < 16 && std::sscanf(text.c_str(), "%4d.%4d%n", &version.major, &version.minor, &end) == 2;
  if (!parsed || static_cast<size_t>(end) != text.size() || version.major < 0 || version.minor < 0) {
    fail_invalid("asset: " + std::string(what) + " " + quoted(text) + " is not a version");
  }
  return version;
}

void check_version(const tinygltf::Asset& asset) {
  const Version version = parse_version(asset.version, "version");
  if (version.major != 2) {
    const std::string name = std::to_string(version.major) + "." + std::to_string(version.minor);
    fail_gltf(ErrorCode::unsupported, "glTF " + name + " is not supported, only 2.x is");
  }
  if (asset.minVersion.empty()) return;
  const Version needed = parse_version(asset.minVersion, "minVersion");
  if (needed > version) fail_invalid("asset: minVersion is above version");
  if (needed > Version{2, 0}) fail_gltf(ErrorCode::unsupported, "needs a glTF newer than 2.0");
}

json parse(std::span<const uint8_t> text) {
  try {
    return json::parse(text.begin(), text.end());
  } catch (const json::parse_error& error) {
    fail_invalid("the JSON is malformed: " + place_in(text, error.byte) + reason_of(error.what()));
  } catch (const json::exception& error) {
    fail_invalid("the JSON is malformed: " + reason_of(error.what()));
  }
}

GltfGated gate_document(json document) {
  if (!document.is_object()) fail_invalid("is not a JSON object");
  // glTF 1.0 keeps its elements in objects by name; its earliest files have no asset, or a version that is a
  // number.
  if (document.contains("meshes") && document["meshes"].is_object()) {
    fail_gltf(ErrorCode::unsupported, "glTF 1.0 is not supported, convert it to glTF 2.0");
  }
  return gate_gltf(std::move(document));
}

// tinygltf reads no file: a buffer is kGltfStub to it.
tinygltf::Model read_model(const GltfGated& gate) {
  const std::string& text = gate.json;
  if (text.size() > UINT32_MAX) fail_gltf(ErrorCode::unsupported, "more than 4 GiB of JSON");
  tinygltf::TinyGLTF reader;
  reader.SetFsCallbacks({[](const std::string&, void*) { return true; },
                         [](const std::string& name, void*) { return name; },
                         [](std::vector<unsigned char>* bytes, std::string*, const std::string&, void*) {
                           bytes->assign(1, 0);
                           return true;
                         },
                         nullptr, nullptr});
  tinygltf::Model model;
  std::string error, warning;
  if (!reader.LoadASCIIFromString(&model, &error, &warning, text.data(), static_cast<unsigned>(text.size()), "",
                                  tinygltf::NO_REQUIRE))
    fail_invalid("tinygltf cannot read it: " + error);
  // What the gate changed for tinygltf's sake:
  model.bufferViews.pop_back();
  const auto none = static_cast<int>(model.bufferViews.size());
  for (tinygltf::Accessor& accessor : model.accessors)
    if (accessor.bufferView == none) accessor.bufferView = -1;
  for (const auto& [view, stride] : gate.strides) model.bufferViews[view].byteStride = stride;
  return model;
}

}  // namespace

std::span<const uint8_t> as_bytes(std::string_view bytes) {
  return {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()};
}

GltfContainer split_gltf(std::span<const uint8_t> file) {
  // The content decides: either extension is found on both containers.
  if (file.size() >= 4 && read_u32(file, 0) == glb_magic) return split_glb(file);
  const bool begins_as_json = !file.empty() && std::string_view("{ \t\r\n\xEF").find(file[0]) != std::string_view::npos;
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    fail_gltf(ErrorCode::unsupported, "UTF-16 text; the JSON of glTF is UTF-8");
  if (!begins_as_json) fail_invalid("neither GLB, which begins with \"glTF\", nor JSON");
  return {.is_binary = false, .json = file, .binary = {}, .others = {}};
}

GltfDocument::GltfDocument(const std::filesystem::path& path, std::string_view bytes)
    : folder_(path.parent_path()),
      container_(split_gltf(as_bytes(bytes))),
      gate_(gate_document(parse(container_.json))),
      model_(read_model(gate_)) {
  gate_.json = {};
  check("/asset");
  check_version(model_.asset);
  check("/extensionsRequired");
  check_required_extensions(model_.extensionsRequired);
}

void GltfDocument::check(const std::string& element) const {
  const auto fault = gate_.faults.find(element);
  if (fault != gate_.faults.end()) fail_invalid(fault->second);
}

std::string GltfDocument::oddity_of_node(uint32_t node) const {
  const auto odd = gate_.oddities.find(node);
  return odd == gate_.oddities.end() ? "" : odd->second;
}

bool GltfDocument::uses_extension(const std::string& name) const {
  const auto lists = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  return lists(model_.extensionsUsed) || lists(model_.extensionsRequired);
}

}  // namespace vcd::baker
