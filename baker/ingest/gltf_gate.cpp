#include "ingest/gltf_gate.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "ingest/gltf_failure.h"

namespace vcd::baker {

using nlohmann::json;
using Rules = nlohmann::ordered_json;

namespace {

// For each property that is read, what it must be:
//   {...}       an object with such properties; those that are not named here do not pass
//   [rule]      an array of what the rule says
//   [a, b, ...] one of these values
//   ">nodes"    the index of a node
//   "size"      an integer up to 2^53; "size32": up to 2^32 - 1, as tinygltf would cut more than that
//   "3 numbers" an array of so many
//   "anything"  is only asked whether it is there, and passes as 0
//   a number, or "": this value passes, whatever the file says
// A "!" behind a name: the property is required. A "?": it is ignored unless it is an object.
const Rules& rules() {
  static const Rules all = Rules::parse(R"({
    "asset": {"version!": "text", "minVersion": "text"},
    "extensionsUsed": ["text"],
    "extensionsRequired": ["text"],
    "buffers": [{"byteLength!": "size", "uri": "text"}],
    "bufferViews": [{
      "buffer!": ">buffers", "byteOffset": "size", "byteLength!": "size", "byteStride": "size",
      "extensions": {
        "EXT_meshopt_compression": {
          "mode": "text", "filter": "text", "count!": "size32", "byteStride!": "size32",
          "buffer!": ">buffers", "byteOffset": "size32", "byteLength!": "size32"},
        "KHR_meshopt_compression": {
          "mode": "text", "filter": "text", "count!": "size32", "byteStride!": "size32",
          "buffer!": ">buffers", "byteOffset": "size32", "byteLength!": "size32"}}}],
    "accessors": [{
      "componentType!": [5120, 5121, 5122, 5123, 5125, 5126], "normalized": "flag", "count!": "size",
      "type!": ["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"],
      "bufferView": ">bufferViews", "byteOffset": "size",
      "sparse": {
        "count!": "size32",
        "indices!": {"componentType!": [5121, 5123, 5125], "bufferView!": ">bufferViews", "byteOffset": "size32"},
        "values!": {"bufferView!": ">bufferViews", "byteOffset": "size32"}}}],
    "materials": [{
      "alphaMode": "text",
      "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": "number", "transmissionTexture": "anything"},
        "KHR_materials_diffuse_transmission":
          {"diffuseTransmissionFactor": "number", "diffuseTransmissionTexture": "anything"},
        "ADOBE_materials_thin_transparency": {"transmissionFactor": "number", "transmissionTexture": "anything"}}}],
    "meshes": [{
      "name": "text",
      "primitives": [{
        "mode": [0, 1, 2, 3, 4, 5, 6], "attributes!": {"POSITION": ">accessors"}, "targets": [{}],
        "material": ">materials", "indices": ">accessors",
        "extensions": {
          "KHR_draco_mesh_compression": {"bufferView!": ">bufferViews", "attributes!": {"POSITION!": "size32"}},
          "KHR_materials_variants": {"mappings": [{"material!": ">materials"}]}}}]}],
    "nodes": [{
      "name": "text", "children": [">nodes"], "mesh": ">meshes", "skin": "anything",
      "matrix": "16 numbers", "translation": "3 numbers", "rotation": "4 numbers", "scale": "3 numbers",
      "extensions": {"EXT_mesh_gpu_instancing": {}, "KHR_lights_punctual": {"light!": ">lights"}},
      "extras?": {"area_light?": {"width": "number", "height": "number"}}}],
    "scenes": [{"nodes": [">nodes"], "extras?": {"sky_light": "flag"}}],
    "scene": ">scenes",
    "extensions": {
      "KHR_lights_punctual": {
        "lights": [{"type!": ["point", "spot", "directional"], "range": "number",
                    "spot": {"outerConeAngle": "number"}}]}},
    "animations": [{
      "channels": [{
        "sampler": 0,
        "target": {"node": 0, "path": "", "extensions": {"KHR_animation_pointer": {"pointer": "text"}}}}]}]
  })");
  return all;
}

// What tinygltf cannot do without, for elements that lack it.
const json& fallbacks() {
  static const json all = json::parse(R"({
    "accessors": {"componentType": 5120, "count": 0, "type": "SCALAR"},
    "bufferViews": {"buffer": 0, "byteLength": 1},
    "primitives": {"attributes": {"POSITION": 0}},
    "lights": {"type": "point"}
  })");
  return all;
}

std::string singular(const std::string& plural) {
  return plural == "meshes" ? "mesh" : plural.substr(0, plural.size() - 1);
}

class Gate {
 public:
  explicit Gate(json& document) {
    static const json::json_pointer lights("/extensions/KHR_lights_punctual/lights");
    for (const auto& [name, value] : document.items()) counts_[name] = value.is_array() ? value.size() : 0;
    if (document.contains(lights) && document[lights].is_array()) counts_["lights"] = document[lights].size();
  }

  GltfGated run(json& document) {
    json passed = json::object();
    for (const auto& [name, rule] : rules().items()) {
      element_ = "/" + name;
      if (document.contains(name) && pass(rule, document[name], name, "")) passed[name] = std::move(document[name]);
    }
    passed["bufferViews"].push_back(fallbacks()["bufferViews"]);
    if (!passed.contains("asset")) gated_.faults.try_emplace("/asset", "the JSON has no asset.version: not glTF");
    document = nullptr;
    gated_.json = passed.dump();
    return std::move(gated_);
  }

 private:
  // Of an element, the first fault counts.
  bool fault(const std::string& place, const std::string& reason) {
    gated_.faults.try_emplace(element_, place.empty() ? reason : place + ": " + reason);
    return false;
  }

  // Whether the value passes; it becomes what does.
  bool pass(const Rules& rule, json& value, const std::string& key, const std::string& place) {
    if (value.is_null()) return false;  // counts as absent
    if (rule.is_object()) return object(rule, value, place.empty() ? key : place + ", " + key);
    if (rule.is_array() && rule.size() == 1) return array(rule[0], value, key, place);
    if (rule.is_array()) return choice(rule, value, key, place);
    return scalar(rule.get_ref<const std::string&>(), value, key, place);
  }

  // All or nothing passes, but of elements what can.
  bool object(const Rules& rule, json& value, const std::string& place) {
    if (!value.is_object()) return fault(place, "is not a JSON object");
    json::object_t given = std::move(value.get_ref<json::object_t&>()), passed;
    bool complete = true;
    for (const auto& [name, property] : rule.items()) {
      const bool required = name.back() == '!', optional = name.back() == '?';
      const std::string key = required || optional ? name.substr(0, name.size() - 1) : name;
      if (property.is_number() || property == "") {
        passed[key] = property;
        continue;
      }
      // What only lights need is asked for apart from their element.
      const bool of_lights =
          (key == "KHR_lights_punctual" || key == "extras") && element_.find('/', 1) != std::string::npos;
      const std::string around = element_;
      if (of_lights) element_ += "/light";
      auto found = given.extract(key);
      if (!found || found.mapped().is_null() || (optional && !found.mapped().is_object())) {
        if (required) complete = fault(place, "has no " + key);
      } else if (pass(property, found.mapped(), key, place)) {
        passed.insert(std::move(found));
      } else {
        complete = complete && of_lights;
      }
      element_ = around;
    }
    value = std::move(passed);
    return complete;
  }

  bool array(const Rules& rule, json& value, const std::string& key, const std::string& place) {
    if (!value.is_array()) return fault(place, key + " is not an array");
    if (rule.is_object() && key != "mappings") {
      for (size_t i = 0; i < value.size(); ++i) element(rule, value[i], key, i);
      return true;
    }
    const std::string inside = place.empty() ? key : place + ", " + key;
    std::erase_if(value.get_ref<json::array_t&>(), [&](json& entry) {
      return !(rule.is_object() ? object(rule, entry, inside) : scalar(rule, entry, "an entry", inside));
    });
    return true;
  }

  // An element has faults of its own, and stays where it is.
  void element(const Rules& rule, json& value, const std::string& key, size_t index) {
    const bool primitive = key == "primitives";
    std::string place = primitive ? "" : singular(key) + " " + std::to_string(index);
    if (key == "nodes" && value.is_object() && value.contains("name") && value["name"].is_string() &&
        value["name"] != "")
      place.append(" ").append(quoted(value["name"]));
    const std::string around = element_;
    element_ = (primitive ? around : "") + "/" + key + "/" + std::to_string(index);
    const bool has_mode = primitive && value.contains("mode");
    if (!object(rule, value, place) && !value.is_object()) value = json::object();
    // A primitive without a POSITION is passed over, one of an unknown mode is not.
    if (has_mode && !value.contains("mode")) value["attributes"].emplace("POSITION", 0);
    if (const auto fallback = fallbacks().find(key); fallback != fallbacks().end())
      for (const auto& [name, missing] : fallback->items()) value.emplace(name, missing);
    adapt(value, key, index, place);
    element_ = around;
  }

  // What tinygltf takes in another way than this folder.
  void adapt(json& value, const std::string& key, size_t index, const std::string& place) {
    if (key == "buffers") {
      gated_.buffers.push_back({"", value.value("byteLength", uint64_t{0})});
      if (value.contains("uri")) gated_.buffers.back().uri.swap(value["uri"].get_ref<std::string&>());
      value = {{"byteLength", 1}, {"uri", kGltfStub}};
    } else if (key == "bufferViews" && value.contains("byteStride")) {
      const uint64_t stride = value["byteStride"];
      if (stride % 4 == 0 && stride <= 252) return;
      gated_.strides[static_cast<uint32_t>(index)] = stride;
      value.erase("byteStride");
    } else if (key == "nodes" && value.contains("matrix")) {
      for (const char* part : {"translation", "rotation", "scale"}) {
        if (!value.contains(part)) continue;
        gated_.oddities[static_cast<uint32_t>(index)] =
            std::string("has both a matrix and a ") + part + "; the matrix taken";
      }
    } else if (key == "accessors") {
      value.emplace("bufferView", counts_["bufferViews"]);
    } else if (key == "lights" && value["type"] == "spot") {
      if (!value.contains("spot")) fault(place, "is a spot without a cone");
      value["spot"].emplace("outerConeAngle", std::numbers::pi / 4);  // tinygltf's has ten digits
    }
  }

  bool scalar(const std::string& rule, json& value, const std::string& key, const std::string& place) {
    if (rule == "text") return value.is_string() || fault(place, key + " is not a string");
    if (rule == "flag") return value.is_boolean() || fault(place, key + " is not true or false");
    if (rule == "anything") return value = 0, true;
    if (rule == "number") {
      if (!value.is_number()) return fault(place, key + " is not a number");
      return value = value.get<double>(), true;  // since tinygltf cuts integers
    }
    if (rule.ends_with(" numbers")) return numbers(std::stoul(rule), value, key, place);
    if (!value.is_number_unsigned()) return fault(place, key + " is not a non-negative integer");
    const uint64_t number = value.get<uint64_t>();
    if (rule == "size") return number <= uint64_t{1} << 53 || fault(place, key + " is above 2^53");
    if (rule == "size32") return number <= UINT32_MAX || fault(place, key + " is above 2^32 - 1");
    const std::string of = rule.substr(1);
    return number < counts_[of] || fault(place, singular(of) + " " + std::to_string(number) +
                                                    " does not exist, the file has " + std::to_string(counts_[of]));
  }

  bool numbers(size_t count, const json& value, const std::string& key, const std::string& place) {
    if (!value.is_array()) return fault(place, key + " is not an array");
    if (value.size() != count)
      return fault(place,
                   key + " has " + std::to_string(value.size()) + " numbers instead of " + std::to_string(count));
    const auto is_number = [](const json& entry) { return entry.is_number(); };
    return std::all_of(value.begin(), value.end(), is_number) ||
           fault(place, key + " holds something else than a number");
  }

  bool choice(const Rules& rule, const json& value, const std::string& key, const std::string& place) {
    const auto is_value = [&](const Rules& each) {
      if (each.is_string()) return value.is_string() && each.get_ref<const std::string&>() == value;
      return value.is_number_unsigned() && each.get<uint64_t>() == value.get<uint64_t>();
    };
    const std::string shown = value.is_string() ? quoted(value) : value.is_number() ? value.dump() : value.type_name();
    return std::any_of(rule.begin(), rule.end(), is_value) || fault(place, key + " " + shown + " does not exist");
  }

  GltfGated gated_;
  std::map<std::string, size_t> counts_;  // of the document's arrays
  std::string element_;                   // that is being looked at
};

}  // namespace

GltfGated gate_gltf(json document) { return Gate(document).run(document); }

}  // namespace vcd::baker
