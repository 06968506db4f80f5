// Strict reading of glTF's JSON: a property of the wrong type is an error, never a default.
//
// Everything in this folder that is named gltf_* reports errors by throwing GltfFailure, which keeps forty
// checks out of the way of the algorithm; ingest_gltf catches it, so that none leaves the folder.
#pragma once

#include <vcd/format/error.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace vcd::baker {

struct GltfFailure {
  Error error;  // the message names the place inside the file, and not yet the file
};

[[noreturn]] void fail_gltf(ErrorCode code, std::string message);
[[noreturn]] void fail_invalid(std::string message);

// A name from the file, quoted for a message: control characters become spaces, long names are cut.
std::string quoted(const std::string& name);

// A JSON object and the words that name it in messages ("accessor 3"). A property that is null counts as absent. Refers
// to the document; copy it freely.
class GltfObject {
 public:
  GltfObject(const nlohmann::json& value, std::string place);  // throws unless it is an object

  const std::string& place() const { return place_; }
  bool has(const char* key) const { return find(key) != nullptr; }

  // Integers must be written as such (no 1.0), must not be negative, and must not exceed 2^53.
  uint64_t integer(const char* key) const;  // required
  uint64_t integer_or(const char* key, uint64_t missing) const;
  // Index of another element of the document, below 2^32; nothing where the property is absent.
  std::optional<uint32_t> index(const char* key) const;
  uint32_t required_index(const char* key) const;

  bool flag(const char* key) const;  // false where absent
  double number_or(const char* key, double missing) const;
  std::string text_or(const char* key, const char* missing) const;

  std::optional<GltfObject> object(const char* key) const;
  std::optional<GltfObject> object_if_one(const char* key) const;  // `extras` may be anything
  GltfObject required_object(const char* key) const;
  std::optional<GltfObject> extension(const char* name) const;
  const nlohmann::json& array(const char* key) const;  // an empty array where absent

  [[noreturn]] void fail(const std::string& reason) const;  // invalid_file, "accessor 3: reason"

 private:
  const nlohmann::json* find(const char* key) const;
  std::string place_of(const char* child) const { return place_.empty() ? child : place_ + ", " + child; }

  const nlohmann::json* value_;
  std::string place_;
};

}  // namespace vcd::baker
