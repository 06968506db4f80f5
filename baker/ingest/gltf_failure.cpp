#include "ingest/gltf_failure.h"

#include <utility>

namespace vcd::baker {

void fail_gltf(ErrorCode code, std::string message) { throw GltfFailure{{code, std::move(message)}}; }

void fail_invalid(std::string message) { fail_gltf(ErrorCode::invalid_file, std::move(message)); }

std::string quoted(const std::string& name) {
  constexpr size_t longest = 80;
  std::string shown = name.substr(0, longest);
  // A cut inside a UTF-8 sequence would leave half a character.
  if (name.size() > longest) {
    while (!shown.empty() && (static_cast<unsigned char>(name[shown.size()]) & 0xC0) == 0x80) shown.pop_back();
    shown += "...";
  }
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  return "\"" + shown + "\"";
}

}  // namespace vcd::baker
