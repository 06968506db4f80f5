#include "ingest/gltf_extensions.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "ingest/gltf_failure.h"

namespace vcd::baker {

namespace {

// Families whose every member, present or future, speaks of something else than the triangles of a mesh.
constexpr std::array<std::string_view, 14> harmless_families = {
    "KHR_materials_", "EXT_materials_", "ADOBE_materials_",  // how a surface looks
    "KHR_texture_",   "EXT_texture_",   "MSFT_texture_",    "MSFT_packing_",
    "KHR_lights_",    "EXT_lights_",    "KHR_xmp",                        // what lights it, who made it
    "KHR_animation_", "KHR_audio_",     "KHR_physics_",     "KHR_node_",  // what moves, sounds or hides a
                                                                          // node
};

constexpr std::array<std::string_view, 23> accepted = {
    // decoded here
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_mesh_quantization",
    // placement of nodes; meshes are read in their own frame
    "EXT_mesh_gpu_instancing",
    "CESIUM_RTC",
    "GODOT_single_root",
    "MSFT_lod",
    // tables and marks on faces and vertices
    "EXT_mesh_features",
    "EXT_instance_features",
    "EXT_structural_metadata",
    "EXT_feature_metadata",
    "CESIUM_primitive_outline",
    "FB_geometry_metadata",
    "EXT_mesh_manifold",
    "AGI_articulations",
    "AGI_stk_metadata",
    "KHR_implicit_shapes",
    // appearance, named outside the families
    "KHR_technique_webgl",
    "KHR_techniques_webgl",
    "KHR_blend",
    "KHR_interactivity",
    "EXT_lightmap",
};

bool is_accepted(std::string_view name) {
  const auto begins_name = [&](std::string_view family) { return name.starts_with(family); };
  return std::find(accepted.begin(), accepted.end(), name) != accepted.end() ||
         std::any_of(harmless_families.begin(), harmless_families.end(), begins_name);
}

}  // namespace

void check_required_extensions(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (is_accepted(name)) continue;
    fail_gltf(ErrorCode::unsupported, "requires the extension " + quoted(name) + ", which is not known");
  }
}

}  // namespace vcd::baker
