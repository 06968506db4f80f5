#include "ingest/gltf_json.h"

#include <utility>

namespace vcd::baker {

using nlohmann::json;

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

GltfObject::GltfObject(const json& value, std::string place) : value_(&value), place_(std::move(place)) {
  if (!value.is_object()) fail("is not a JSON object");
}

const json* GltfObject::find(const char* key) const {
  const auto found = value_->find(key);
  return found == value_->end() || found->is_null() ? nullptr : &*found;
}

uint64_t GltfObject::integer(const char* key) const {
  const json* found = find(key);
  if (found == nullptr) fail(std::string("has no ") + key);
  if (!found->is_number_unsigned()) fail(std::string(key) + " is not a non-negative integer");
  const uint64_t value = found->get<uint64_t>();
  if (value > uint64_t{1} << 53) fail(std::string(key) + " is above 2^53");
  return value;
}

uint64_t GltfObject::integer_or(const char* key, uint64_t missing) const { return has(key) ? integer(key) : missing; }

std::optional<uint32_t> GltfObject::index(const char* key) const {
  if (!has(key)) return std::nullopt;
  return required_index(key);
}

uint32_t GltfObject::required_index(const char* key) const {
  const uint64_t value = integer(key);
  if (value > UINT32_MAX) fail(std::string(key) + " " + std::to_string(value) + " does not exist");
  return static_cast<uint32_t>(value);
}

bool GltfObject::flag(const char* key) const {
  const json* found = find(key);
  if (found == nullptr) return false;
  if (!found->is_boolean()) fail(std::string(key) + " is not true or false");
  return found->get<bool>();
}

double GltfObject::number_or(const char* key, double missing) const {
  const json* found = find(key);
  if (found == nullptr) return missing;
  if (!found->is_number()) fail(std::string(key) + " is not a number");
  return found->get<double>();
}

std::string GltfObject::text_or(const char* key, const char* missing) const {
  const json* found = find(key);
  if (found == nullptr) return missing;
  if (!found->is_string()) fail(std::string(key) + " is not a string");
  return found->get<std::string>();
}

std::optional<GltfObject> GltfObject::object(const char* key) const {
  const json* found = find(key);
  if (found == nullptr) return std::nullopt;
  return GltfObject(*found, place_of(key));
}

std::optional<GltfObject> GltfObject::object_if_one(const char* key) const {
  const json* found = find(key);
  return found != nullptr && found->is_object() ? object(key) : std::nullopt;
}

GltfObject GltfObject::required_object(const char* key) const {
  std::optional<GltfObject> child = object(key);
  if (!child) fail(std::string("has no ") + key);
  return *child;
}

std::optional<GltfObject> GltfObject::extension(const char* name) const {
  const json* extensions = find("extensions");
  if (extensions == nullptr) return std::nullopt;
  return GltfObject(*extensions, place_of("extensions")).object(name);
}

const json& GltfObject::array(const char* key) const {
  static const json empty = json::array();
  const json* found = find(key);
  if (found == nullptr) return empty;
  if (!found->is_array()) fail(std::string(key) + " is not an array");
  return *found;
}

void GltfObject::fail(const std::string& reason) const {
  fail_invalid(place_.empty() ? reason : place_ + ": " + reason);
}

}  // namespace vcd::baker
