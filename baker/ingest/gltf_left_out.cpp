#include "ingest/gltf_left_out.h"

namespace vcd::baker {

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

std::optional<std::string> why_not_opaque(const GltfElement<tinygltf::Material>& material) {
  if (material->alphaMode != "OPAQUE") return "alphaMode " + quoted(material->alphaMode) + " in " + material.place;
  for (const Transmission& known : kTransmissions) {
    const auto extension = extension_of(material, known.extension);
    if (extension && ((*extension)->Get(known.factor).GetNumberAsDouble() > 0 || (*extension)->Has(known.texture)))
      return "transmission in " + material.place;
  }
  return std::nullopt;
}

// Whether a channel of an animation points into an extension of the material by which light passes through
// (KHR_animation_pointer). Animations are not checked otherwise: defects of theirs do no harm here.
bool is_transmission_animated(const GltfDocument& document, uint32_t material) {
  const std::string begin = "/materials/" + std::to_string(material) + "/extensions/";
  for (const tinygltf::Animation& animation : document.model().animations) {
    for (const tinygltf::AnimationChannel& channel : animation.channels) {
      const auto pointer = channel.target_extensions.find("KHR_animation_pointer");
      if (pointer == channel.target_extensions.end()) continue;
      const std::string& target = pointer->second.Get("pointer").Get<std::string>();
      for (const Transmission& known : kTransmissions)
        if (target.starts_with(begin + known.extension + "/")) return true;
    }
  }
  return false;
}

std::vector<uint32_t> materials_of(const tinygltf::Primitive& primitive) {
  std::vector<uint32_t> materials;
  if (primitive.material >= 0) materials.push_back(static_cast<uint32_t>(primitive.material));
  const auto variants = primitive.extensions.find("KHR_materials_variants");
  if (variants == primitive.extensions.end()) return materials;
  const tinygltf::Value& mappings = variants->second.Get("mappings");
  for (size_t i = 0; i < mappings.ArrayLen(); ++i)
    materials.push_back(number_in(mappings.Get(static_cast<int>(i)), "material"));
  return materials;
}

}  // namespace

std::vector<bool> find_skinned_meshes(const GltfDocument& document) {
  std::vector<bool> skinned(document.model().meshes.size());
  for (const tinygltf::Node& node : document.model().nodes)
    if (node.skin >= 0 && node.mesh >= 0) skinned[static_cast<size_t>(node.mesh)] = true;
  return skinned;
}

std::optional<GltfLeftOut> why_left_out(const GltfDocument& document, const tinygltf::Primitive& primitive,
                                        bool skinned) {
  if (skinned) return GltfLeftOut{GltfLeftOutBecause::deforms, "a node deforms it with a skin"};
  if (!primitive.targets.empty()) return GltfLeftOut{GltfLeftOutBecause::deforms, "it has morph targets"};
  for (const uint32_t index : materials_of(primitive)) {
    if (const std::optional<std::string> reason = why_not_opaque(document.material(index))) {
      return GltfLeftOut{GltfLeftOutBecause::not_opaque, *reason};
    }
    if (is_transmission_animated(document, index))
      return GltfLeftOut{GltfLeftOutBecause::not_opaque,
                         "an animation changes the transmission of material " + std::to_string(index)};
  }
  return std::nullopt;
}

}  // namespace vcd::baker
