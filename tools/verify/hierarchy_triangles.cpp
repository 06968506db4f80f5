#include "hierarchy_triangles.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <vector>

namespace vcd::verify {
namespace {

using baker::PreparedMesh;

class Comparison {
 public:
  Comparison(const HierarchyView& hierarchy, const PreparedMesh& mesh)
      : hierarchy_(hierarchy), mesh_(mesh), seen_(mesh.triangles.size()) {}

  // What is wrong, if anything is.
  std::optional<std::string> run() {
    if (!is_good_below(kRootUnit)) return fault_;
    const auto missing = static_cast<uint64_t>(std::count(seen_.begin(), seen_.end(), false));
    if (missing > 0) return "it lacks " + std::to_string(missing) + " of the mesh's triangles";
    return std::nullopt;
  }

 private:
  bool fail(uint32_t child, const std::string& what) {
    fault_ = "the leaf at unit " + std::to_string(child & kUnitMask) + " holds " + what;
    return false;
  }

  bool is_good_below(uint32_t unit) {
    for (const uint32_t child : hierarchy_.node(unit).child) {
      if (child == kNoChild) break;
      const bool good = child & kLeafChild
                            ? with_leaf(hierarchy_, child, [&](const auto& l) { return is_good(l, child); })
                            : is_good_below(child);
      if (!good) return false;
    }
    return true;
  }

  template <uint32_t kVertices>
  bool is_good(const HierarchyLeaf<kVertices>& leaf, uint32_t child) {
    uint32_t index[kVertices];
    for (uint32_t v = 0; v < kVertices; ++v) {
      const auto found = index_of({leaf.vertex[0][v], leaf.vertex[1][v], leaf.vertex[2][v]});
      if (!found) return fail(child, "a vertex that the mesh has not");
      index[v] = *found;
    }
    for (uint32_t t = 0; t < static_cast<uint32_t>(std::popcount(leaf.present)); ++t) {
      baker::TriangleIndices triangle = {index[leaf.corner[0][t]], index[leaf.corner[1][t]], index[leaf.corner[2][t]]};
      std::ranges::sort(triangle);
      const auto at = std::ranges::lower_bound(mesh_.triangles, triangle);
      if (at == mesh_.triangles.end() || *at != triangle) return fail(child, "a triangle that the mesh has not");
      auto seen = seen_[static_cast<size_t>(at - mesh_.triangles.begin())];
      if (seen) return fail(child, "a triangle that another one holds too");
      seen = true;
    }
    return true;
  }

  // Of a prepared mesh, whose positions are sorted and have no -0.
  std::optional<uint32_t> index_of(const baker::Position& position) const {
    const auto at = std::ranges::lower_bound(mesh_.positions, position);
    using Bits = std::array<uint32_t, 3>;
    if (at == mesh_.positions.end() || std::bit_cast<Bits>(*at) != std::bit_cast<Bits>(position)) return std::nullopt;
    return static_cast<uint32_t>(at - mesh_.positions.begin());
  }

  const HierarchyView hierarchy_;
  const PreparedMesh& mesh_;
  std::vector<bool> seen_;  // of the mesh's triangles
  std::string fault_;
};

}  // namespace

void check_triangles(const HierarchyView& hierarchy, const PreparedMesh& mesh, const std::string& place,
                     Outcome& outcome) {
  if (!hierarchy) return;
  if (const auto fault = Comparison(hierarchy, mesh).run())
    outcome.add(IssueId::hierarchy_triangles, ErrorCode::invalid_file, place, *fault);
}

}  // namespace vcd::verify
