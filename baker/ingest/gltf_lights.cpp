#include "ingest/gltf_lights.h"

#include <cmath>
#include <numbers>
#include <string>

namespace vcd::baker {
namespace {

using Vector = SceneLight::Vector;

Vector column(const std::array<double, 12>& to_scene, size_t i) {
  return {to_scene[i], to_scene[4 + i], to_scene[8 + i]};
}

// The node's -z, where lights shine (KHR_lights_punctual).
Vector shining(const GltfElement<tinygltf::Node>& node, const std::array<double, 12>& to_scene) {
  const Vector z = column(to_scene, 2);
  const double length = std::sqrt(z[0] * z[0] + z[1] * z[1] + z[2] * z[2]);
  if (!std::isnormal(length)) node.fail("its transform leaves its light no direction");
  return {-z[0] / length, -z[1] / length, -z[2] / length};
}

// The angle where a spot's light ends; KHR_lights_punctual: a quarter of pi where none is given.
double cone_cosine(const GltfElement<tinygltf::Light>& light) {
  const double angle = light->spot.outerConeAngle;
  if (!(angle > 0 && angle <= std::numbers::pi / 2)) light.fail("outerConeAngle is not from 0 to a quarter turn");
  return std::cos(angle);
}

SceneLight punctual(const GltfElement<tinygltf::Node>& node, const GltfElement<tinygltf::Light>& light,
                    const std::array<double, 12>& to_scene) {
  SceneLight result;
  result.position = column(to_scene, 3);
  if (light->type != "point") result.direction = shining(node, to_scene);
  if (light->type == "directional") result.shape = SceneLight::Shape::directional;
  if (light->type == "spot") result.cone_cosine = cone_cosine(light);
  result.range = light->range;
  if (!(result.range >= 0)) light.fail("range is negative");
  return result;
}

SceneLight rectangle(const GltfElement<tinygltf::Node>& node, const tinygltf::Value& area,
                     const std::array<double, 12>& to_scene) {
  SceneLight result;
  result.shape = SceneLight::Shape::rectangle;
  result.position = column(to_scene, 3);
  result.direction = shining(node, to_scene);
  for (const auto& [i, key] : {std::pair(0u, "width"), std::pair(1u, "height")}) {
    const double size = area.Get(key).GetNumberAsDouble();
    if (!(size > 0)) node.fail("extras, area_light: " + std::string(key) + " is not greater than 0");
    for (size_t axis = 0; axis < 3; ++axis) result.half_edges[i][axis] = column(to_scene, i)[axis] * size / 2;
  }
  return result;
}

}  // namespace

std::optional<SceneLight> light_of_node(const GltfDocument& document, const GltfElement<tinygltf::Node>& node,
                                        const std::array<double, 12>& to_scene) {
  if (const auto reference = extension_of(node, "KHR_lights_punctual"))
    return punctual(node, document.light(number_in(*reference->object, "light")), to_scene);
  if (!node->extras.Has("area_light")) return std::nullopt;
  return rectangle(node, node->extras.Get("area_light"), to_scene);
}

bool has_sky_light(const tinygltf::Scene& scene) {
  return scene.extras.Has("sky_light") && scene.extras.Get("sky_light").Get<bool>();
}

}  // namespace vcd::baker
