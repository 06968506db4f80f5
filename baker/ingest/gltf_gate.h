// What of a glTF file's JSON reaches tinygltf, which would take an optional property of the wrong type for an absent
// one, cut integers to 32 bits, and refuse a whole file for an element that nothing uses.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace vcd::baker {

struct GltfBufferSource {
  std::string uri;  // empty where there is none
  uint64_t byte_length = 0;
};

struct GltfGated {
  // Holds only properties that are read here, each of its type, and each index of an element that exists. A property
  // that broke this is left out, or replaced by a value that tinygltf takes.
  std::string json;
  // What was broken, by element: "/accessors/3", "/meshes/0/primitives/1", "/lights/2"; "/meshes" if that is no array;
  // "/nodes/2/light" and "/scenes/0/light" for what only lights need.
  // An element of which nothing is said is sound. The message names element and property.
  std::map<std::string, std::string> faults;
  std::map<uint32_t, std::string> oddities;  // of nodes: what is wrong and without consequence
  // Of buffers and views, what tinygltf would not take as it is. It also gets one view more than the file has, for the
  // accessors that have none.
  std::vector<GltfBufferSource> buffers;  // tinygltf gets a byte instead of each, named kGltfStub
  std::map<uint32_t, uint64_t> strides;   // by view: a byteStride that glTF forbids
};

inline constexpr const char* kGltfStub = "stub";

// document: the JSON of a file, an object. Throws nothing but bad_alloc.
GltfGated gate_gltf(nlohmann::json document);

}  // namespace vcd::baker
