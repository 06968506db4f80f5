#pragma once

#include <filesystem>
#include <string>

namespace vcd::tools {

// The path as a URI reference (RFC 3986): file:///… if it is absolute, else relative. Every byte that is neither
// unreserved nor a slash is percent-encoded, so that any name comes back byte for byte.
std::string uri_of(const std::filesystem::path& path);

}  // namespace vcd::tools
