#include <vcd/baker/attach.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <new>

#include "attach/attach_gltf.h"
#include "ingest/check.h"
#include "ingest/gltf_failure.h"

namespace vcd::baker {
namespace {

// As the line stands behind the comment's keyword.
std::string line_of(const Attachment& attachment) {
  return std::string(kAttachedName) + " " + attachment.uri + " " + hex_of(attachment.meshes[0].geometry_hash);
}

std::string_view line_end(std::string_view bytes) {
  const size_t end = bytes.find_first_of("\r\n");
  if (end == std::string_view::npos || bytes[end] == '\n') return "\n";
  return bytes.substr(end).starts_with("\r\n") ? "\r\n" : "\r";
}

// Behind the first `lines` lines.
size_t behind(std::string_view bytes, size_t lines) {
  const std::string_view end = line_end(bytes);
  size_t at = 0;
  for (; lines > 0; --lines) {
    const size_t found = bytes.find(end, at);
    if (found == std::string_view::npos) fail_invalid("its header ends too early");
    at = found + end.size();
  }
  return at;
}

std::string with_comment(std::string_view bytes, size_t at, std::string_view keyword, const Attachment& attachment) {
  if (!attachment.embedded.empty())
    fail_gltf(ErrorCode::usage, "only glTF can hold a sidecar itself; others name it in a comment");
  if (is_attached(bytes)) fail_has_one();
  std::string text(bytes);
  text.insert(at, std::string(keyword) + " " + line_of(attachment) + std::string(line_end(bytes)));
  return text;
}

std::string attach_by_extension(const std::filesystem::path& path, std::string_view bytes,
                                const Attachment& attachment) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".gltf" || extension == ".glb") return attach_gltf(path, bytes, attachment);
  if (attachment.meshes.size() != 1) fail_gltf(ErrorCode::usage, "no sidecar of one mesh");
  if (extension == ".ply") return with_comment(bytes, behind(bytes, 2), "comment", attachment);  // behind its format
  if (extension == ".obj") return with_comment(bytes, bytes.starts_with("\xEF\xBB\xBF") ? 3 : 0, "#", attachment);
  fail_gltf(ErrorCode::usage, "a sidecar can be attached to glTF, GLB, PLY and OBJ only");
}

}  // namespace

std::string hex_of(const GeometryHash& hash) {
  std::string text;
  for (const uint8_t byte : hash) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", byte);
    text += digits;
  }
  return text;
}

void fail_has_one() {
  fail_gltf(ErrorCode::usage, "has a sidecar attached already: attach this one to the file that it was made of");
}

bool is_attached(std::string_view bytes) { return bytes.find(kAttachedName) != std::string_view::npos; }

Result<std::string> attach(const std::filesystem::path& path, std::string_view bytes,
                           const Attachment& attachment) try {
  return attach_by_extension(path, bytes, attachment);
} catch (const GltfFailure& failure) {
  return file_error(path, failure.error.code, failure.error.message);
} catch (const std::bad_alloc&) {
  return file_error(path, ErrorCode::runtime, "out of memory");
}

}  // namespace vcd::baker
