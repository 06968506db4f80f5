// A glTF 2.0 file taken out of its container: the JSON and, for GLB, the binary chunk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "ingest/gltf_json.h"

namespace vcd::baker {

std::span<const uint8_t> as_bytes(std::string_view bytes);

// A file's bytes, taken apart; the parts point into them.
struct GltfContainer {
  bool is_binary = false;           // GLB, whatever the file is called
  std::span<const uint8_t> json;    // its text
  std::span<const uint8_t> binary;  // GLB: of its binary chunk; empty where there is none
  std::span<const uint8_t> others;  // GLB: chunks of other types, as they stand
};

// Throws GltfFailure: invalid_file or unsupported (a broken container, UTF-16, GLB of another version).
GltfContainer split_gltf(std::span<const uint8_t> file);

class GltfDocument {
 public:
  // Checks container, version and required extensions of a file's bytes, which outlive this. The JSON's elements
  // are checked when they are asked for, so that a defect in a part that has no say in the triangles stays without
  // consequence. Throws GltfFailure: invalid_file (broken container or JSON), unsupported (glTF 1.0, unknown
  // extension).
  GltfDocument(const std::filesystem::path& path, std::string_view bytes);

  const std::filesystem::path& folder() const { return folder_; }  // what relative URIs start from
  bool is_binary() const { return container_.is_binary; }
  std::span<const uint8_t> binary_chunk() const { return container_.binary; }  // empty where there is none

  size_t count(const char* array) const { return root().array(array).size(); }
  const nlohmann::json& array(const char* name) const { return root().array(name); }
  // A top-level index, such as ("scene"); nothing where it is absent.
  std::optional<uint32_t> index(const char* key) const { return root().index(key); }
  // One element of a top-level array, such as ("accessors", 3). Throws where there is none.
  GltfObject element(const char* array, uint32_t index) const;
  std::optional<GltfObject> extension(const char* name) const { return root().extension(name); }  // of the whole file
  bool uses_extension(const std::string& name) const;  // listed as used or as required

 private:
  GltfObject root() const { return GltfObject(json_, ""); }

  std::filesystem::path folder_;
  GltfContainer container_;
  nlohmann::json json_;
};

}  // namespace vcd::baker
