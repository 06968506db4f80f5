#include <vcd/scenes/glb.h>

#include <algorithm>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <string>

#include <tiny_gltf.h>

#include "vec.h"

namespace vcd::scenes {
namespace {

using tinygltf::Model;
using tinygltf::Value;

// Appends to the only buffer; returns the index of the view.
template <class Item>
int add_view(Model& model, const std::vector<Item>& items, int target) {
  std::vector<unsigned char>& data = model.buffers[0].data;
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = data.size();
  view.byteLength = items.size() * sizeof(Item);
  view.target = target;
  const auto* bytes = reinterpret_cast<const unsigned char*>(items.data());
  data.insert(data.end(), bytes, bytes + view.byteLength);
  model.bufferViews.push_back(view);
  return static_cast<int>(model.bufferViews.size()) - 1;
}

tinygltf::Accessor accessor(int view, int component, size_t count, int type) {
  tinygltf::Accessor accessor;
  accessor.bufferView = view;
  accessor.componentType = component;
  accessor.count = count;
  accessor.type = type;
  return accessor;
}

// Of each mesh k: buffer views and accessors 2k (indices) and 2k + 1 (positions), material k.
void add_mesh(Model& model, const Mesh& mesh) {
  if (mesh.triangles.empty()) throw std::invalid_argument("to_glb: mesh " + mesh.name + " has no triangle");
  Vec3 low = mesh.positions[0], high = low;
  for (const Vec3& p : mesh.positions) {
    for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
  }
  const int indices = add_view(model, mesh.triangles, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  const int positions = add_view(model, mesh.positions, TINYGLTF_TARGET_ARRAY_BUFFER);
  model.accessors.push_back(
      accessor(indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, 3 * mesh.triangles.size(), TINYGLTF_TYPE_SCALAR));
  model.accessors.push_back(
      accessor(positions, TINYGLTF_COMPONENT_TYPE_FLOAT, mesh.positions.size(), TINYGLTF_TYPE_VEC3));
  model.accessors.back().minValues.assign(low.begin(), low.end());
  model.accessors.back().maxValues.assign(high.begin(), high.end());

  tinygltf::Primitive primitive;
  primitive.attributes["POSITION"] = positions;
  primitive.indices = indices;
  primitive.material = static_cast<int>(model.materials.size());
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  tinygltf::Material material;
  material.pbrMetallicRoughness.baseColorFactor = {mesh.colour[0], mesh.colour[1], mesh.colour[2], 1};
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.doubleSided = true;
  model.materials.push_back(material);
  model.meshes.emplace_back();
  model.meshes.back().name = mesh.name;
  model.meshes.back().primitives.push_back(primitive);
}

tinygltf::Node& add_node(Model& model, const std::string& name, const Transform& t) {
  model.scenes[0].nodes.push_back(static_cast<int>(model.nodes.size()));
  tinygltf::Node& node = model.nodes.emplace_back();
  node.name = name;
  if (t == kIdentity) return node;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) node.matrix.push_back(t[4 * row + column]);
    node.matrix.push_back(column == 3 ? 1 : 0);
  }
  return node;
}

Transform frame(Vec3 x, Vec3 y, Vec3 z, Vec3 p) {
  return {x[0], y[0], z[0], p[0], x[1], y[1], z[1], p[1], x[2], y[2], z[2], p[2]};
}

// A glTF camera looks along its node's -z, +y up.
void add_camera(Model& model, const Camera& camera) {
  const Double3 position = to_double(camera.position), way = to_double(camera.target) - position;
  const Double3 back = unit(position - to_double(camera.target)), right = unit(cross(kUp, back));
  add_node(model, "camera", frame(to_float(right), to_float(cross(back, right)), to_float(back), camera.position))
      .camera = 0;
  model.cameras.emplace_back();
  model.cameras[0].type = "perspective";
  model.cameras[0].perspective.yfov = camera.vertical_fov_degrees * kPi / 180;
  model.cameras[0].perspective.znear = length(way) / 1000;
  model.cameras[0].perspective.zfar = length(way) * 1000;  // tinygltf writes 0 for none, which glTF forbids
}

// vcd's area light (spec/demand.md): a rectangle in its node's xy plane that shines along -z.
void add_light(Model& model, const AreaLight& light) {
  const Double3 u = to_double(light.edge_u), v = to_double(light.edge_v), back = unit(cross(v, u));
  const Double3 middle = to_double(light.corner) + 0.5 * (u + v);
  const Value size(Value::Object{{"width", Value(length(v))}, {"height", Value(length(u))}});
  add_node(model, "light", frame(to_float(unit(v)), to_float(unit(u)), to_float(back), to_float(middle))).extras =
      Value(Value::Object{{"area_light", size}});
}

uint64_t bytes_of(const Mesh& mesh) {
  return mesh.triangles.size() * sizeof mesh.triangles[0] + mesh.positions.size() * sizeof mesh.positions[0];
}

}  // namespace

std::vector<std::byte> to_glb(const Scene& scene) {
  uint64_t binary = 0;
  for (const Mesh& mesh : scene.meshes) binary += bytes_of(mesh);
  constexpr const char* kTooLarge = "to_glb: the file would be larger than the 4 GiB that GLB allows";
  if (binary > UINT32_MAX) throw std::length_error(kTooLarge);

  Model model;
  model.asset.generator = "vcd";
  model.defaultScene = 0;
  model.scenes.emplace_back();
  model.scenes[0].name = scene.name;
  model.buffers.emplace_back();
  model.buffers[0].data.reserve(binary);
  for (const Mesh& mesh : scene.meshes) add_mesh(model, mesh);
  for (const Instance& instance : scene.instances)
    add_node(model, "", instance.transform).mesh = static_cast<int>(instance.mesh);
  add_camera(model, scene.camera);
  for (const AreaLight& light : scene.lights) add_light(model, light);

  std::ostringstream out;
  tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, out, /*prettyPrint=*/false, /*writeBinary=*/true);
  const std::string_view text = out.view();
  if (text.size() > UINT32_MAX) throw std::length_error(kTooLarge);
  const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
  return {bytes, bytes + text.size()};
}

}  // namespace vcd::scenes
