#include <vcd/baker/hierarchy.h>

#include <algorithm>

#include "hierarchy/binary_tree.h"
#include "hierarchy/blocking_order.h"
#include "hierarchy/collapse.h"
#include "hierarchy/emit.h"
#include "hierarchy/reinsert.h"
#include "hierarchy/wide_tree.h"

namespace vcd::baker {
namespace {

// So that the nodes of a binary tree have indices of 32 bits.
constexpr size_t kMostTriangles = size_t{1} << 31;

WideTree collapsed(const PreparedMesh& mesh, Stop& stop, Bounds& box) {
  BinaryTree binary = build_binary_tree(mesh, stop);
  if (stop.stopped()) return {};
  reinsert(binary, stop);
  box = binary.nodes[0].box;
  const std::vector<Collapse> choices = choose_collapse(mesh, binary, stop);
  return stop.stopped() ? WideTree{} : make_wide_tree(mesh, binary, choices);
}

}  // namespace

bool can_have_hierarchy(const PreparedMesh& mesh) {
  Bounds box;
  for (const Position& p : mesh.positions) box.add(p);
  float min[3], max[3];
  std::ranges::copy(box.min, min), std::ranges::copy(box.max, max);
  const float greatest = greatest_coordinate(min, max);
  return greatest >= kLeastHierarchyCoordinate && greatest <= kMostHierarchyCoordinate;
}

std::optional<HierarchySection> build_hierarchy(const PreparedMesh& mesh, const std::function<bool()>& ask) {
  if (mesh.triangles.size() > kMostTriangles) return HierarchySection{};
  Stop stop(ask);
  Bounds box;
  WideTree tree = collapsed(mesh, stop, box);
  if (stop.stopped()) return std::nullopt;
  order_children(mesh, tree, box, stop);
  if (stop.stopped()) return std::nullopt;
  return emit(tree, box, mesh.triangles.size());
}

}  // namespace vcd::baker
