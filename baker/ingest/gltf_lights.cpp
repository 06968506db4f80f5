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
Vector shining(const GltfObject& node, const std::array<double, 12>& to_scene) {
  const Vector z = column(to_scene, 2);
  const double length = std::sqrt(z[0] * z[0] + z[1] * z[1] + z[2] * z[2]);
  if (!std::isnormal(length)) node.fail("its transform leaves its light no direction");
  return {-z[0] / length, -z[1] / length, -z[2] / length};
}

// The angle where a spot's light ends; KHR_lights_punctual: a quarter of pi where none is given.
double cone_cosine(const GltfObject& light) {
  const std::optional<GltfObject> spot = light.object("spot");
  if (!spot) light.fail("is a spot without a cone");
  const double angle = spot->number_or("outerConeAngle", std::numbers::pi / 4);
  if (!(angle > 0 && angle <= std::numbers::pi / 2)) spot->fail("outerConeAngle is not from 0 to a quarter turn");
  return std::cos(angle);
}

SceneLight punctual(const GltfObject& node, const GltfObject& light, const std::array<double, 12>& to_scene) {
  SceneLight result;
  const std::string type = light.text_or("type", "");
  if (type != "point" && type != "spot" && type != "directional") light.fail("type is not point, spot or directional");
  result.position = column(to_scene, 3);
  if (type != "point") result.direction = shining(node, to_scene);
  if (type == "directional") result.shape = SceneLight::Shape::directional;
  if (type == "spot") result.cone_cosine = cone_cosine(light);
  result.range = light.number_or("range", 0);
  if (!(result.range >= 0)) light.fail("range is negative");
  return result;
}

SceneLight rectangle(const GltfObject& node, const GltfObject& area, const std::array<double, 12>& to_scene) {
  SceneLight result;
  result.shape = SceneLight::Shape::rectangle;
  result.position = column(to_scene, 3);
  result.direction = shining(node, to_scene);
  for (const auto& [i, key] : {std::pair(0u, "width"), std::pair(1u, "height")}) {
    const double size = area.number_or(key, 0);
    if (!(size > 0)) area.fail(std::string(key) + " is not greater than 0");
    for (size_t axis = 0; axis < 3; ++axis) result.half_edges[i][axis] = column(to_scene, i)[axis] * size / 2;
  }
  return result;
}

}  // namespace

std::optional<SceneLight> light_of_node(const GltfDocument& document, const GltfObject& node,
                                        const std::array<double, 12>& to_scene) {
  if (const auto reference = node.extension("KHR_lights_punctual")) {
    const uint32_t index = reference->required_index("light");
    const auto all = document.extension("KHR_lights_punctual");
    const size_t count = all ? all->array("lights").size() : 0;
    if (index >= count)
      node.fail("light " + std::to_string(index) + " does not exist, the file has " + std::to_string(count));
    return punctual(node, GltfObject(all->array("lights")[index], "light " + std::to_string(index)), to_scene);
  }
  const auto extras = node.object_if_one("extras");
  if (!extras) return std::nullopt;
  const auto area = extras->object_if_one("area_light");
  return area ? std::optional(rectangle(node, *area, to_scene)) : std::nullopt;
}

bool has_sky_light(const GltfObject& scene) {
  const auto extras = scene.object_if_one("extras");
  return extras && extras->flag("sky_light");
}

}  // namespace vcd::baker
