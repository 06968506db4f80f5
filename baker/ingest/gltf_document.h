// A glTF 2.0 file taken out of its container: the JSON and, for GLB, the binary chunk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "ingest/gltf_failure.h"
#include "ingest/gltf_gate.h"
#include "ingest/tinygltf.h"

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

// An element of the document, and the words that name it in messages ("accessor 3").
template <class Object>
struct GltfElement {
  const Object* object;
  std::string place;

  const Object* operator->() const { return object; }
  [[noreturn]] void fail(const std::string& reason) const { fail_invalid(place + ": " + reason); }
};

// An extension of an element, if it has it.
template <class Object>
std::optional<GltfElement<tinygltf::Value>> extension_of(const GltfElement<Object>& element, const char* name) {
  const auto found = element->extensions.find(name);
  if (found == element->extensions.end()) return std::nullopt;
  return GltfElement<tinygltf::Value>{&found->second, element.place + ", extensions, " + name};
}

// A "size32" or an index of GltfGated, which a Value holds as a signed number; 0 where it is absent.
inline uint32_t number_in(const tinygltf::Value& object, const char* key) {
  return static_cast<uint32_t>(object.Get(key).GetNumberAsInt());
}

class GltfDocument {
 public:
  // Checks container, version and required extensions of a file's bytes, which outlive this. What is broken of an
  // element counts when the element is asked for, so that a defect in a part that has no say in the triangles stays
  // without consequence. Throws GltfFailure: invalid_file (broken container or JSON), unsupported (glTF 1.0, unknown
  // extension).
  GltfDocument(const std::filesystem::path& path, std::string_view bytes);

  const std::filesystem::path& folder() const { return folder_; }  // what relative URIs start from
  bool is_binary() const { return container_.is_binary; }
  std::span<const uint8_t> binary_chunk() const { return container_.binary; }  // empty where there is none

  // Indices in it are of elements that exist. Read elements by the functions below, which know what is broken.
  const tinygltf::Model& model() const { return model_; }
  GltfElement<tinygltf::Accessor> accessor(uint32_t i) const { return element(model_.accessors, "accessor", i); }
  GltfElement<tinygltf::BufferView> view(uint32_t i) const { return element(model_.bufferViews, "bufferView", i); }
  GltfElement<tinygltf::Material> material(uint32_t i) const { return element(model_.materials, "material", i); }
  GltfElement<tinygltf::Node> node(uint32_t i) const { return element(model_.nodes, "node", i); }
  GltfElement<tinygltf::Scene> scene(uint32_t i) const { return element(model_.scenes, "scene", i); }
  GltfElement<tinygltf::Light> light(uint32_t i) const { return element(model_.lights, "light", i); }
  GltfElement<tinygltf::Mesh> mesh(uint32_t i) const { return element(model_.meshes, "mesh", i, "/meshes/"); }
  GltfElement<GltfBufferSource> buffer(uint32_t i) const { return element(gate_.buffers, "buffer", i); }

  // Throws what is broken of an element, by its name in GltfGated::faults.
  void check(const std::string& element) const;
  std::string oddity_of_node(uint32_t node) const;     // or nothing
  bool uses_extension(const std::string& name) const;  // listed as used or as required

 private:
  template <class Object>
  GltfElement<Object> element(const std::vector<Object>& all, const std::string& name, uint32_t index,
                              const std::string& pointer = {}) const {
    if (index >= all.size())
      fail_invalid(name + " " + std::to_string(index) + " does not exist, the file has " + std::to_string(all.size()));
    check((pointer.empty() ? "/" + name + "s/" : pointer) + std::to_string(index));
    return {&all[index], name + " " + std::to_string(index)};
  }

  std::filesystem::path folder_;
  GltfContainer container_;
  GltfGated gate_;
  tinygltf::Model model_;
};

}  // namespace vcd::baker
