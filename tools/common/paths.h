// Paths of any bytes, for people and in JSON.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <vcd/format/error.h>

#include "describe.h"

namespace vcd::tools {

// For messages: control characters as \xNN, so that a name keeps to its line; bytes beyond ASCII too if they are not
// UTF-8.
std::string shown(const std::filesystem::path& path);

// What the page of a sidecar is named beside it, behind the sidecar's own name.
inline constexpr std::string_view kPageEnding = ".html";

// In lower case, without its dot.
std::string extension_of(const std::filesystem::path& path);

// A text, or where the path is not UTF-8 {"bytes": "…"}, two hexadecimal digits a byte.
Json path_to_json(const std::filesystem::path& path);
Result<std::filesystem::path> path_from_json(const Json& json);  // Error (usage)

}  // namespace vcd::tools
