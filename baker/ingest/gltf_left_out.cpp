#include "ingest/gltf_left_out.h"

namespace vcd {

using nlohmann::json;

namespace {

std::optional<std::string> why_not_opaque(const GltfObject& material) {
  const std::string alpha_mode = material.text_or("alphaMode", "OPAQUE");
  if (alpha_mode != "OPAQUE") return "alphaMode " + quoted(alpha_mode) + " in " + material.place();
  const std::optional<GltfObject> transmission = material.extension("KHR_materials_transmission");
  const bool transmits = transmission && (transmission->number_or("transmissionFactor", 0) > 0 ||
                                          transmission->has("transmissionTexture"));
  if (transmits) return "transmission in " + material.place();
  return std::nullopt;
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
    if (!node.is_object() || !node.contains("skin") || !node.contains("mesh")) continue;
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
  }
  return std::nullopt;
}

}  // namespace vcd
