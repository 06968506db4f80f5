#include "ingest/gltf_left_out.h"

namespace vcd::baker {

using nlohmann::json;

namespace {

// Extensions by which light passes through a surface.
struct Transmission {
  const char *extension, *factor, *texture;
};
constexpr Transmission kTransmissions[] = {
    {"KHR_materials_transmission", "transmissionFactor", "transmissionTexture"},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionFactor", "diffuseTransmissionTexture"},
    {"ADOBE_materials_thin_transparency", "transmissionFactor", "transmissionTexture"},
};

std::optional<std::string> why_not_opaque(const GltfObject& material) {
  const std::string alpha_mode = material.text_or("alphaMode", "OPAQUE");
  if (alpha_mode != "OPAQUE") return "alphaMode " + quoted(alpha_mode) + " in " + material.place();
  for (const Transmission& known : kTransmissions) {
    const std::optional<GltfObject> extension = material.extension(known.extension);
    if (extension && (extension->number_or(known.factor, 0) > 0 || extension->has(known.texture)))
      return "transmission in " + material.place();
  }
  return std::nullopt;
}

// Whether a channel of an animation points into an extension of the material by which light passes through
// (KHR_animation_pointer). Animations are not checked otherwise: defects of theirs do no harm here.
bool is_transmission_animated(const GltfDocument& document, uint32_t material) {
  if (!document.uses_extension("KHR_animation_pointer")) return false;
  const std::string begin = "/materials/" + std::to_string(material) + "/extensions/";
  const json::json_pointer pointer("/target/extensions/KHR_animation_pointer/pointer");
  for (const json& animation : document.array("animations")) {
    const json& channels = animation.is_object() && animation.contains("channels") ? animation["channels"] : json();
    for (const json& channel : channels) {
      if (!channel.contains(pointer) || !channel[pointer].is_string()) continue;
      const std::string target = channel[pointer].get<std::string>();
      for (const Transmission& known : kTransmissions)
        if (target.starts_with(begin + known.extension + "/")) return true;
    }
  }
  return false;
}

std::vector<uint32_t> materials_of(const GltfObject& primitive) {
  std::vector<uint32_t> materials;
  if (const std::optional<uint32_t> material = primitive.index("material")) materials.push_back(*material);
  const std::optional<GltfObject> variants = primitive.extension("KHR_materials_variants");
  if (!variants) return materials;
  for (const json& entry : variants->array("mappings")) {
    materials.push_back(GltfObject(entry, variants->place() + ", mappings").required_index("material"));
  }
  return materials;
}

}  // namespace

std::vector<bool> find_skinned_meshes(const GltfDocument& document) {
  std::vector<bool> skinned(document.count("meshes"));
  for (const json& node : document.array("nodes")) {
    if (!node.is_object() || !node.contains("skin") || node["skin"].is_null() || !node.contains("mesh")) continue;
    const json& mesh = node["mesh"];
    if (mesh.is_number_unsigned() && mesh.get<uint64_t>() < skinned.size()) skinned[mesh.get<size_t>()] = true;
  }
  return skinned;
}

std::optional<GltfLeftOut> why_left_out(const GltfDocument& document, const GltfObject& primitive, bool skinned) {
  if (skinned) return GltfLeftOut{GltfLeftOutBecause::deforms, "a node deforms it with a skin"};
  if (!primitive.array("targets").empty()) return GltfLeftOut{GltfLeftOutBecause::deforms, "it has morph targets"};
  for (const uint32_t index : materials_of(primitive)) {
    if (const std::optional<std::string> reason = why_not_opaque(document.element("materials", index))) {
      return GltfLeftOut{GltfLeftOutBecause::not_opaque, *reason};
    }
    if (is_transmission_animated(document, index))
      return GltfLeftOut{GltfLeftOutBecause::not_opaque,
                         "an animation changes the transmission of material " + std::to_string(index)};
  }
  return std::nullopt;
}

}  // namespace vcd::baker
