#include "paths.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdio>

namespace vcd::tools {
namespace {

bool is_utf8(const std::string& text) try {
  (void)Json(text).dump();
  return true;
} catch (const Json::exception&) {
  return false;
}

}  // namespace

std::string shown(const std::filesystem::path& path) {
  const bool utf8 = is_utf8(path.native());
  std::string text;
  for (const char c : path.native()) {
    const auto byte = static_cast<unsigned char>(c);
    char escaped[5];
    std::snprintf(escaped, sizeof escaped, "\\x%02x", byte);
    text += byte < 32 || byte == 127 || (byte > 127 && !utf8) ? std::string(escaped) : std::string(1, c);
  }
  return text;
}

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string().substr(path.has_extension());
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

Json path_to_json(const std::filesystem::path& path) {
  if (is_utf8(path.native())) return path.native();
  std::string digits;
  for (const char c : path.native()) {
    char byte[3];
    std::snprintf(byte, sizeof byte, "%02x", static_cast<unsigned char>(c));
    digits += byte;
  }
  return {{"bytes", digits}};
}

Result<std::filesystem::path> path_from_json(const Json& json) {
  const Error fault{ErrorCode::usage, "a path is neither a text nor {\"bytes\": \"…\"}"};
  if (json.is_string()) return std::filesystem::path(json.get<std::string>());
  if (!json.is_object() || !json.contains("bytes") || !json["bytes"].is_string()) return fault;
  const std::string digits = json["bytes"].get<std::string>();
  std::string path;
  for (size_t i = 0; i < digits.size(); i += 2) {
    unsigned byte = 0;
    const auto end = std::from_chars(digits.data() + i, digits.data() + std::min(i + 2, digits.size()), byte, 16).ptr;
    if (end != digits.data() + i + 2) return fault;
    path += static_cast<char>(byte);
  }
  return std::filesystem::path(path);
}

}  // namespace vcd::tools
