// URIs of glTF buffers.
#pragma once

#include <string>
#include <string_view>

namespace vcd::baker {

bool is_data_uri(std::string_view uri);

// "http:…", "file:…", "data:…": anything but a relative reference.
bool has_scheme(std::string_view uri);

// "%20" to " "; a "%" that no two hexadecimal digits follow stays, as exporters forget to escape it.
std::string percent_decode(std::string_view text);

// The bytes of "data:[type][;base64],payload", whatever the type. Throws GltfFailure (invalid_file).
std::string decode_data_uri(std::string_view uri);

}  // namespace vcd::baker
