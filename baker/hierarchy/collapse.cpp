#include "hierarchy/collapse.h"

#include <algorithm>

#include "hierarchy/both_sides.h"

namespace vcd::baker {
namespace {

// A subtree that may be one leaf becomes several only where one would cost more than this times as much: fewer and
// fuller leaves take fewer bytes, which makes up for what they are visited more often.
constexpr float kOneLeafWorth = 1.75f;

// The distinct vertices of a subtree that may be a leaf, ascending.
struct Vertices {
  std::array<uint32_t, kLargeVertices> index;
  uint32_t count;  // more than kLargeVertices: too many, and `index` is not filled in

  bool fit() const { return count <= kLargeVertices; }
};
constexpr uint32_t kTooMany = kLargeVertices + 1;

void merge(const Vertices& a, const Vertices& b, Vertices& sum) {
  sum.count = kTooMany;
  if (!a.fit() || !b.fit()) return;
  uint32_t n = 0;
  for (uint32_t i = 0, k = 0; i < a.count || k < b.count; ++n) {
    if (n == kLargeVertices) return;
    const bool from_a = k == b.count || (i < a.count && a.index[i] <= b.index[k]);
    const uint32_t vertex = from_a ? a.index[i] : b.index[k];
    i += from_a, k += k < b.count && b.index[k] == vertex;
    sum.index[n] = vertex;
  }
  sum.count = n;
}

struct Subtree {
  std::array<float, kNodeWidth> cost;  // as at most i + 1 children
  Vertices vertices;
};

// The cheapest way to share `slots` children out to two subtrees, one each at the least.
struct Share {
  uint8_t left = 0;
  float cost = Bounds::kInfinity;
};
Share cheapest_share(const Subtree& left, const Subtree& right, uint32_t slots) {
  Share best;
  for (uint32_t l = 1; l < slots; ++l) {
    const float cost = left.cost[l - 1] + right.cost[slots - l - 1];
    if (cost < best.cost) best = {static_cast<uint8_t>(l), cost};
  }
  return best;
}

class Chooser {
 public:
  Chooser(const PreparedMesh& mesh, const BinaryTree& tree, std::vector<Collapse>& choices, Stop& stop)
      : mesh_(mesh), tree_(tree), choices_(choices), stop_(stop) {}

  void visit(uint32_t node, Subtree& result) {
    const uint32_t count = tree_.nodes[node].count;
    if (count == 1) return single(node, result);
    if (count >= kOwnTask && stop_.now()) return;
    Subtree left, right;
    both_sides(
        count, [&] { visit(tree_.left(node), left); }, [&] { visit(tree_.right(node), right); });
    result.vertices.count = kTooMany;
    if (count <= kNodeWidth) merge(left.vertices, right.vertices, result.vertices);
    choose(node, left, right, result);
  }

 private:
  void single(uint32_t node, Subtree& result) {
    const BinaryNode& n = tree_.nodes[node];
    std::ranges::copy(mesh_.triangles[tree_.triangles[n.first]], result.vertices.index.begin());  // they are ascending
    result.vertices.count = 3;
    result.cost.fill(Box::of(n.box).half_area());
    choices_[node].left.fill(0);
  }

  void choose(uint32_t node, const Subtree& left, const Subtree& right, Subtree& result) {
    const float area = Box::of(tree_.nodes[node].box).half_area();
    Collapse& choice = choices_[node];
    const Share wide = cheapest_share(left, right, kNodeWidth);
    const bool is_leaf = result.vertices.fit();  // a leaf costs no more than a node
    choice.of(1) = is_leaf ? 0 : wide.left;
    result.cost[0] = is_leaf ? area : area + wide.cost;
    for (uint32_t slots = 2; slots <= kNodeWidth; ++slots) {
      const Share share = slots == kNodeWidth ? wide : cheapest_share(left, right, slots);
      const bool is_one = result.cost[0] <= (is_leaf ? kOneLeafWorth : 1) * share.cost;
      choice.of(slots) = is_one ? 0 : share.left;
      result.cost[slots - 1] = is_one ? result.cost[0] : share.cost;
    }
  }

  const PreparedMesh& mesh_;
  const BinaryTree& tree_;
  std::vector<Collapse>& choices_;
  Stop& stop_;
};

}  // namespace

std::vector<Collapse> choose_collapse(const PreparedMesh& mesh, const BinaryTree& tree, Stop& stop) {
  std::vector<Collapse> choices(tree.nodes.size());
  Subtree root;
  Chooser(mesh, tree, choices, stop).visit(0, root);
  return choices;
}

}  // namespace vcd::baker
