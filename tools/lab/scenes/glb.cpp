#include <vcd/scenes/glb.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "vec.h"

namespace vcd::scenes {
namespace {

using Json = nlohmann::ordered_json;

// The numbers of the glTF 2.0 specification.
constexpr uint32_t kMagic = 0x46546C67, kVersion = 2, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr int kUnsignedInt = 5125, kFloat = 5126, kArrayBuffer = 34962, kElementArrayBuffer = 34963;

static_assert(std::endian::native == std::endian::little, "meshes are copied into the file as they are in memory");

uint64_t index_bytes(const Mesh& mesh) { return mesh.triangles.size() * sizeof mesh.triangles[0]; }
uint64_t position_bytes(const Mesh& mesh) { return mesh.positions.size() * sizeof mesh.positions[0]; }

// Of each mesh k: buffer views and accessors 2k (indices) and 2k + 1 (positions), material k.
void describe_mesh(Json& document, const Mesh& mesh, uint64_t& byte_offset) {
  if (mesh.triangles.empty()) throw std::invalid_argument("to_glb: mesh " + mesh.name + " has no triangle");
  Vec3 low = mesh.positions[0], high = low;
  for (const Vec3& p : mesh.positions) {
    for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
  }
  const size_t first = document["accessors"].size();
  const auto view = [&](uint64_t bytes, int target) {
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", byte_offset}, {"byteLength", bytes}, {"target", target}});
    byte_offset += bytes;
  };
  view(index_bytes(mesh), kElementArrayBuffer);
  view(position_bytes(mesh), kArrayBuffer);
  document["accessors"].push_back({{"bufferView", first},
                                   {"componentType", kUnsignedInt},
                                   {"count", 3 * mesh.triangles.size()},
                                   {"type", "SCALAR"}});
  document["accessors"].push_back({{"bufferView", first + 1},
                                   {"componentType", kFloat},
                                   {"count", mesh.positions.size()},
                                   {"type", "VEC3"},
                                   {"min", low},
                                   {"max", high}});
  const size_t material = document["materials"].size();
  document["materials"].push_back(
      {{"pbrMetallicRoughness",
        {{"baseColorFactor", {mesh.colour[0], mesh.colour[1], mesh.colour[2], 1}}, {"metallicFactor", 0}}},
       {"doubleSided", true}});
  const Json primitive = {{"attributes", {{"POSITION", first + 1}}}, {"indices", first}, {"material", material}};
  document["meshes"].push_back({{"name", mesh.name}, {"primitives", Json::array({primitive})}});
}

Json column_major(const Transform& t) {
  Json matrix = Json::array();
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) matrix.push_back(t[4 * row + column]);
    matrix.push_back(column == 3 ? 1 : 0);
  }
  return matrix;
}

// A glTF camera looks along its node's -z, +y up.
Json camera_node(const Camera& camera) {
  const Double3 position = to_double(camera.position);
  const Double3 back = unit(position - to_double(camera.target)), right = unit(cross(kUp, back));
  const Vec3 x = to_float(right), y = to_float(cross(back, right)), z = to_float(back), &p = camera.position;
  return {{"name", "camera"},
          {"camera", 0},
          {"matrix", column_major({x[0], y[0], z[0], p[0], x[1], y[1], z[1], p[1], x[2], y[2], z[2], p[2]})}};
}

void describe_camera(Json& document, const Camera& camera) {
  const double distance = length(to_double(camera.target) - to_double(camera.position));
  const Json perspective = {{"yfov", camera.vertical_fov_degrees * kPi / 180}, {"znear", distance / 1000}};
  document["cameras"] = Json::array({{{"type", "perspective"}, {"perspective", perspective}}});
  document["nodes"].push_back(camera_node(camera));
}

// vcd's area light (spec/demand.md): a rectangle in its node's xy plane that shines along -z.
Json light_node(const AreaLight& light) {
  const Double3 u = to_double(light.edge_u), v = to_double(light.edge_v), back = unit(cross(v, u));
  const Double3 middle = to_double(light.corner) + 0.5 * (u + v);
  const Vec3 x = to_float(unit(v)), y = to_float(unit(u)), z = to_float(back), p = to_float(middle);
  return {{"name", "light"},
          {"matrix", column_major({x[0], y[0], z[0], p[0], x[1], y[1], z[1], p[1], x[2], y[2], z[2], p[2]})},
          {"extras", {{"area_light", {{"width", length(v)}, {"height", length(u)}}}}}};
}

Json describe(const Scene& scene, uint64_t& binary_bytes) {
  Json document;
  document["asset"] = {{"version", "2.0"}, {"generator", "vcd"}};
  document["scene"] = 0;
  document["scenes"] = Json::array();
  for (const char* list : {"nodes", "meshes", "materials", "accessors", "bufferViews"}) document[list] = Json::array();
  binary_bytes = 0;
  for (const Mesh& mesh : scene.meshes) describe_mesh(document, mesh, binary_bytes);
  for (const Instance& instance : scene.instances) {
    Json node = {{"mesh", instance.mesh}};
    if (instance.transform != kIdentity) node["matrix"] = column_major(instance.transform);
    document["nodes"].push_back(node);
  }
  describe_camera(document, scene.camera);
  for (const AreaLight& light : scene.lights) document["nodes"].push_back(light_node(light));
  Json roots = Json::array();
  for (size_t i = 0; i < document["nodes"].size(); ++i) roots.push_back(i);
  document["scenes"].push_back({{"name", scene.name}, {"nodes", roots}});
  document["buffers"] = Json::array({{{"byteLength", binary_bytes}}});
  return document;
}

class Output {
 public:
  explicit Output(uint64_t size) : bytes_(size) {}
  void words(std::initializer_list<uint32_t> values) { append(values.begin(), values.size() * sizeof(uint32_t)); }
  void append(const void* data, uint64_t size) {
    std::memcpy(bytes_.data() + used_, data, size);
    used_ += size;
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
  uint64_t used_ = 0;
};

}  // namespace

std::vector<std::byte> to_glb(const Scene& scene) {
  uint64_t binary_bytes = 0;
  std::string text = describe(scene, binary_bytes).dump();
  text.append((4 - text.size() % 4) % 4, ' ');
  const uint64_t size = 12 + 8 + text.size() + 8 + binary_bytes;
  if (size > UINT32_MAX) throw std::length_error("to_glb: the file would be larger than the 4 GiB that GLB allows");

  Output out(size);
  out.words({kMagic, kVersion, static_cast<uint32_t>(size), static_cast<uint32_t>(text.size()), kJsonChunk});
  out.append(text.data(), text.size());
  out.words({static_cast<uint32_t>(binary_bytes), kBinaryChunk});
  for (const Mesh& mesh : scene.meshes) {
    out.append(mesh.triangles.data(), index_bytes(mesh));
    out.append(mesh.positions.data(), position_bytes(mesh));
  }
  return out.take();
}

}  // namespace vcd::scenes
