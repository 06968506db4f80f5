// The extension VCD_visibility, written into glTF's JSON and a GLB file's binary chunk.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <vcd/baker/attach.h>

namespace vcd::baker {

inline constexpr std::string_view kAttachedName = "VCD_visibility";

// As attach(). Throws GltfFailure.
std::string attach_gltf(const std::filesystem::path& path, std::string_view bytes, const Attachment& attachment);

std::string hex_of(const GeometryHash& hash);
[[noreturn]] void fail_has_one();

}  // namespace vcd::baker
