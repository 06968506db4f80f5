// The lights of a glTF file's nodes.
#pragma once

#include <array>
#include <optional>

#include <vcd/baker/scene_light.h>

#include "ingest/gltf_document.h"

namespace vcd::baker {

// The light of a node, if it has one: a light of KHR_lights_punctual, or an area light, which glTF has no extension for
// and which stands in the node's `extras`: {"area_light": {"width": w, "height": h}}, a rectangle in the node's xy
// plane that shines along its -z. to_scene: row-major 3 x 4. Throws GltfFailure (invalid_file), which names the node:
// an index out of range, an unknown type, a size that is not positive, a transform that leaves no direction.
std::optional<SceneLight> light_of_node(const GltfDocument& document, const GltfElement<tinygltf::Node>& node,
                                        const std::array<double, 12>& to_scene);

// Whether a scene is lit by the sky: {"sky_light": true} in its `extras`.
bool has_sky_light(const tinygltf::Scene& scene);

}  // namespace vcd::baker
