#include "health_report.h"

#include <cstdio>
#include <map>

#include "readable.h"

namespace vcd::tools {

using namespace baker;
namespace {

std::string counted(uint64_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

double share(uint32_t part, uint32_t whole) { return whole ? static_cast<double>(part) / whole : 0; }

// Lines or points between the vertices of one part.
class ObjPart {
 public:
  ObjPart(const PreparedMesh& mesh, uint64_t before) : mesh_(mesh), before_(before) {}

  uint64_t number(uint32_t vertex) {
    const auto [known, is_new] = numbers_.emplace(vertex, before_ + numbers_.size() + 1);
    if (is_new) {
      char line[96];
      const Position& p = mesh_.positions[vertex];
      std::snprintf(line, sizeof line, "v %.9g %.9g %.9g\n", static_cast<double>(p[0]), static_cast<double>(p[1]),
                    static_cast<double>(p[2]));
      vertices_ += line;
    }
    return known->second;
  }
  void edges(const std::string& group, const std::vector<MeshHealth::Edge>& edges) {
    if (!edges.empty()) elements_ += "g " + group + "\n";
    for (const auto& [a, b] : edges)
      elements_ += "l " + std::to_string(number(a)) + " " + std::to_string(number(b)) + "\n";
  }
  void points(const std::string& group, const std::vector<uint32_t>& vertices) {
    if (!vertices.empty()) elements_ += "g " + group + "\n";
    for (const uint32_t vertex : vertices) elements_ += "p " + std::to_string(number(vertex)) + "\n";
  }
  uint64_t last() const { return before_ + numbers_.size(); }
  std::string text() const { return vertices_ + elements_; }

 private:
  const PreparedMesh& mesh_;
  uint64_t before_;
  std::map<uint32_t, uint64_t> numbers_;
  std::string vertices_, elements_;
};

}  // namespace

Json describe_health(const MeshHealth& health) {
  return {{"components", health.components},
          {"closed", health.closed()},
          {"boundary_edges", health.boundary_edges.size()},
          {"boundary_loops", health.boundary_loops},
          {"nonmanifold_edges", health.nonmanifold_edges.size()},
          {"nonmanifold_vertices", health.nonmanifold_vertices.size()}};
}

Json describe_proofs(const BlockedProofs& proofs) {
  return {{"level", proofs.level},
          {"cells", proofs.cells},
          {"look_blocked", proofs.look_blocked},
          {"proven", proofs.proven},
          {"at_boundary", proofs.at_boundary},
          {"at_nonmanifold", proofs.at_nonmanifold}};
}

std::string health_summary(const MeshHealth& health) {
  std::string text = "  surface   " + counted(health.components, "piece", "pieces");
  text += health.closed() ? ", closed"
                          : ", open: " + counted(health.boundary_edges.size(), "boundary edge", "boundary edges") +
                                " in " + counted(health.boundary_loops, "loop", "loops");
  if (health.is_manifold()) return text + "; manifold\n";
  return text + "; " + counted(health.nonmanifold_edges.size(), "non-manifold edge", "non-manifold edges") + " and " +
         counted(health.nonmanifold_vertices.size(), "vertex", "vertices") + "\n";
}

std::string proofs_summary(const BlockedProofs& proofs) {
  const auto of_blocked = [&](uint32_t part) { return readable_percent(share(part, proofs.look_blocked)); };
  return "  proofs    of " + std::to_string(proofs.look_blocked) + " cells of level " + std::to_string(proofs.level) +
         " that 16 rays find blocked, " + of_blocked(proofs.proven) + " are proven;\n            " +
         of_blocked(proofs.at_boundary) + " are not, with a sheet that ends at a boundary edge, " +
         of_blocked(proofs.at_nonmanifold) + " with one at a non-manifold edge\n";
}

std::string culprits_as_obj(const PreparedMesh& mesh, const MeshHealth& health, uint64_t& before) {
  ObjPart part(mesh, before);
  part.edges("boundary", health.boundary_edges);
  part.edges("nonmanifold", health.nonmanifold_edges);
  part.points("nonmanifold_vertices", health.nonmanifold_vertices);
  before = part.last();
  return "o " + std::to_string(mesh.source_index) + "\n" + part.text();
}

}  // namespace vcd::tools
