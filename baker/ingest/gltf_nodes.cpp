#include "ingest/gltf_nodes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "ingest/gltf_lights.h"

namespace vcd::baker {

namespace {

using Matrix = std::array<double, 12>;  // row-major 3 x 4, as Placement::transform
constexpr Matrix kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
constexpr const char* kNotFinite = "its transform is not finite in single precision";

// What `inner` does, then what `outer` does.
Matrix product(const Matrix& outer, const Matrix& inner) {
  Matrix result;
  for (size_t row = 0; row < 12; row += 4) {
    for (size_t column = 0; column < 4; ++column) {
      result[row + column] = outer[row] * inner[column] + outer[row + 1] * inner[4 + column] +
                             outer[row + 2] * inner[8 + column] + (column == 3 ? outer[row + 3] : 0);
    }
  }
  return result;
}

// Exporters round: what is as near to 0, 0, 0, 1 as floats are exact, is it.
constexpr double kLastRow = 1e-5;

// Numbers are finite: one that a double cannot hold makes the whole JSON malformed. `odd` gets what is wrong with the
// node and without consequence, a clause, or keeps what it says.
Matrix local_transform(const tinygltf::Node& node, std::string& odd) {
  if (const auto& m = node.matrix; !m.empty()) {  // column-major
    const bool affine = std::fabs(m[3]) <= kLastRow && std::fabs(m[7]) <= kLastRow && std::fabs(m[11]) <= kLastRow &&
                        std::fabs(m[15] - 1) <= kLastRow;
    if (!affine) odd = "the last row of its matrix is not 0, 0, 0, 1; taken as if it were";
    return {m[0], m[4], m[8], m[12], m[1], m[5], m[9], m[13], m[2], m[6], m[10], m[14]};
  }
  const auto given = [](const std::vector<double>& numbers, std::vector<double> missing) {
    return numbers.empty() ? missing : numbers;
  };
  const auto t = given(node.translation, {0, 0, 0}), s = given(node.scale, {1, 1, 1});
  auto q = given(node.rotation, {0, 0, 0, 1});
  // The quaternions of files are rounded; dividing by the length makes them turn and nothing else.
  double length2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!std::isnormal(length2)) {
    odd = "its rotation has no direction; taken as none";
    q = {0, 0, 0, 1}, length2 = 1;
  }
  const double f = 2 / length2;
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  const std::array<double, 3> row_x = {1 - f * (y * y + z * z), f * (x * y - z * w), f * (x * z + y * w)};
  const std::array<double, 3> row_y = {f * (x * y + z * w), 1 - f * (x * x + z * z), f * (y * z - x * w)};
  const std::array<double, 3> row_z = {f * (x * z - y * w), f * (y * z + x * w), 1 - f * (x * x + y * y)};
  return {row_x[0] * s[0], row_x[1] * s[1], row_x[2] * s[2], t[0],  //
          row_y[0] * s[0], row_y[1] * s[1], row_y[2] * s[2], t[1],  //
          row_z[0] * s[0], row_z[1] * s[1], row_z[2] * s[2], t[2]};
}

class NodeReader {
 public:
  NodeReader(const GltfDocument& document, bool lights, Ingested& ingested)
      : document_(document), lights_(lights), ingested_(ingested), nodes_(document.model().nodes.size()) {
    document.check("/nodes");
    for (uint32_t i = 0; i < ingested.meshes.size(); ++i) mesh_of_source_.emplace(ingested.meshes[i].source_index, i);
  }

  void read() {
    find_parents();
    sort_parents_first();
    mark_roots_of_scene();
    for (const uint32_t index : parents_first_) find_transform(index);
    for (uint32_t index = 0; index < nodes_.size(); ++index) {
      if (nodes_[index].in_scene) place(index);
    }
    if (lights_) read_lights();
    if (ingested_.placements.empty()) note("no node of the default scene places a mesh");
  }

 private:
  struct Node {
    std::optional<uint32_t> parent;
    bool in_scene = false;
    bool lost = false;            // hangs on a cycle
    Matrix to_scene = kIdentity;  // once it and its ancestors have been read
  };

  using Element = GltfElement<tinygltf::Node>;

  Element node(uint32_t index) const {
    Element node = document_.node(index);
    if (!node->name.empty()) node.place.append(" ").append(quoted(node->name));
    return node;
  }

  // The first parent that names a node is its parent.
  void find_parents() {
    for (uint32_t index = 0; index < nodes_.size(); ++index) {
      for (const int entry : document_.node(index)->children) {
        const auto child = static_cast<uint32_t>(entry);
        if (!nodes_[child].parent) {
          nodes_[child].parent = index;
        } else if (*nodes_[child].parent != index) {
          note(node(child).place + ": is a child of node " + std::to_string(*nodes_[child].parent) +
               " and again of node " + std::to_string(index) + "; the first taken");
        }
      }
    }
  }

  // As each node has one parent at most, what cannot be reached from a node without one hangs on a cycle.
  void sort_parents_first() {
    std::vector<bool> passed(nodes_.size());
    const auto pass = [&](uint32_t index) {
      if (!passed[index]) parents_first_.push_back(index);
      passed[index] = true;
    };
    for (uint32_t index = 0; index < nodes_.size(); ++index) {
      if (!nodes_[index].parent) pass(index);
    }
    for (size_t i = 0; i < parents_first_.size(); ++i) {
      const uint32_t parent = parents_first_[i];
      for (const int entry : document_.model().nodes[parent].children) {
        if (const auto child = static_cast<uint32_t>(entry); nodes_[child].parent == parent) pass(child);
      }
    }
    for (uint32_t index = 0; index < nodes_.size(); ++index) {
      if (passed[index]) continue;
      nodes_[index].lost = true;
      note(node(index).place + " left out: it hangs on a cycle of nodes");
    }
  }

  void mark_roots_of_scene() {
    document_.check("/scene");
    document_.check("/scenes");
    if (document_.model().scenes.empty()) {
      for (Node& each : nodes_) each.in_scene = !each.parent;
      return;
    }
    const auto scene = default_scene();
    for (const int entry : scene->nodes) {
      const auto root = static_cast<uint32_t>(entry);
      if (nodes_[root].parent && !nodes_[root].lost) {
        note(node(root).place + ": is a root of " + scene.place + " and a child of node " +
             std::to_string(*nodes_[root].parent) + ", in whose frame it stands");
      }
      nodes_[root].in_scene = !nodes_[root].lost;
    }
  }

  uint32_t scene_index() const { return static_cast<uint32_t>(std::max(document_.model().defaultScene, 0)); }
  GltfElement<tinygltf::Scene> default_scene() const { return document_.scene(scene_index()); }

  void find_transform(uint32_t index) {
    Node& here = nodes_[index];
    if (here.parent && nodes_[*here.parent].in_scene) here.in_scene = true;
    std::string odd = document_.oddity_of_node(index);
    const Matrix local = local_transform(*document_.node(index).object, odd);
    if (here.in_scene && !odd.empty()) note(node(index).place + ": " + odd);
    here.to_scene = here.parent ? product(nodes_[*here.parent].to_scene, local) : local;
  }

  void place(uint32_t index) {
    const Element here = node(index);
    if (here->mesh < 0) return;
    const auto mesh = mesh_of_source_.find(static_cast<uint32_t>(here->mesh));
    if (mesh == mesh_of_source_.end()) return;  // a note has said why
    if (here->extensions.contains("EXT_mesh_gpu_instancing")) {
      note(here.place + " left out: its instances (EXT_mesh_gpu_instancing) are not read");
      return;
    }
    const Placement placement{mesh->second, nodes_[index].to_scene};
    if (const char* reason = why_not_invertible(placement.transform)) {
      note(here.place + " left out: " + reason);
    } else {
      ingested_.placements.push_back(placement);
    }
  }

  void read_lights() {
    for (uint32_t index = 0; index < nodes_.size(); ++index) {
      if (!nodes_[index].in_scene) continue;
      document_.check("/nodes/" + std::to_string(index) + "/light");
      if (const auto light = light_of_node(document_, node(index), nodes_[index].to_scene))
        ingested_.lights.push_back(*light);
    }
    if (document_.model().scenes.empty()) return;
    document_.check("/scenes/" + std::to_string(scene_index()) + "/light");
    if (!has_sky_light(*default_scene().object)) return;
    ingested_.lights.emplace_back();
    ingested_.lights.back().shape = SceneLight::Shape::sky;
  }

  void note(std::string sentence) { ingested_.notes.push_back(std::move(sentence)); }

  const GltfDocument& document_;
  bool lights_;
  Ingested& ingested_;
  std::unordered_map<uint32_t, uint32_t> mesh_of_source_;
  std::vector<Node> nodes_;
  std::vector<uint32_t> parents_first_;
};

}  // namespace

void read_placements(const GltfDocument& document, bool lights, Ingested& ingested) {
  NodeReader(document, lights, ingested).read();
}

const char* why_not_invertible(const std::array<double, 12>& transform) {
  const auto is_float = [](double value) { return std::fabs(value) <= std::numeric_limits<float>::max(); };
  if (!std::all_of(transform.begin(), transform.end(), is_float)) return kNotFinite;
  const auto m = [&](size_t row, size_t column) { return double{static_cast<float>(transform[4 * row + column])}; };
  double determinant = 0;  // the volume of the unit cube's image, negative if mirrored
  double volume = 1;       // what it would be if the edges had stayed orthogonal
  for (size_t i = 0; i < 3; ++i) {
    const size_t j = (i + 1) % 3, k = (i + 2) % 3;
    determinant += m(0, i) * (m(1, j) * m(2, k) - m(1, k) * m(2, j));
    volume *= std::sqrt(m(0, i) * m(0, i) + m(1, i) * m(1, i) + m(2, i) * m(2, i));
  }
  const double size = std::fabs(determinant);
  if (size > std::numeric_limits<float>::max()) return kNotFinite;
  // A zero scale between two rotations comes out as what rounding leaves of it.
  constexpr double kRounding = 4 * std::numeric_limits<float>::epsilon();
  if (size < std::numeric_limits<float>::min() || size <= kRounding * volume) return "its scale is zero";
  return nullptr;
}

}  // namespace vcd::baker
