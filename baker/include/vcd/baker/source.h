// The files that a mesh came from, told apart by their content and never by their time.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include <vcd/format/error.h>

namespace vcd::baker {

using ContentHash = std::array<uint8_t, 16>;  // XXH3-128, most significant byte first

struct SourceFile {
  std::string name;  // relative to the mesh file's folder; may lead out of it. Any bytes
  ContentHash hash{};

  bool operator==(const SourceFile&) const = default;
};

ContentHash content_hash(std::string_view bytes);

// The whole of a regular file; pipes and devices, which could keep the reader for ever, are refused. Errors: io.
Result<std::string> read_file(const std::filesystem::path& path);

// content_hash() of such a file, which is not held in memory as a whole. Errors: io.
Result<ContentHash> hash_file(const std::filesystem::path& path);

}  // namespace vcd::baker
