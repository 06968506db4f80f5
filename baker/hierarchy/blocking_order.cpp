#include "hierarchy/blocking_order.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <numeric>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "hierarchy/sample_rays.h"

namespace vcd::baker {
namespace {

constexpr uint32_t kMostRays = 40'000;
constexpr uint32_t kRaysPerTriangle = 4;
// Nodes and leaves that a ray may visit. Few rays need as many; meshes in which all triangles overlap end in time.
constexpr uint32_t kMostSteps = 500;

// What rays found that met a child's box.
struct Visits {
  std::atomic<uint32_t> blocked = 0;
  std::atomic<uint64_t> steps = 0;  // nodes and leaves visited up to the first hit
};
using NodeVisits = std::array<Visits, kNodeWidth>;

// The children whose boxes a ray meets.
uint32_t boxes_met(const HierarchyNode& node, const SampleRay& ray) {
  float enter[kNodeWidth], leave[kNodeWidth];
  std::fill_n(enter, kNodeWidth, ray.t_min), std::fill_n(leave, kNodeWidth, ray.t_max);
  for (size_t a = 0; a < 3; ++a) {
    const bool forward = ray.reciprocal[a] > 0;
    const float* near = forward ? node.min[a] : node.max[a];
    const float* far = forward ? node.max[a] : node.min[a];
    for (size_t i = 0; i < kNodeWidth; ++i) {
      enter[i] = std::max(enter[i], (near[i] - ray.origin[a]) * ray.reciprocal[a]);
      leave[i] = std::min(leave[i], (far[i] - ray.origin[a]) * ray.reciprocal[a]);
    }
  }
  uint32_t met = 0;
  for (uint32_t i = 0; i < kNodeWidth; ++i) met |= static_cast<uint32_t>(enter[i] <= leave[i]) << i;
  return met;
}

template <uint32_t kVertices>
bool is_blocked_by(const HierarchyLeaf<kVertices>& leaf, const SampleRay& ray) {
  float x[kVertices], y[kVertices], z[kVertices];
  for (uint32_t v = 0; v < kVertices; ++v) {
    z[v] = leaf.vertex[ray.z][v] - ray.origin[ray.z];
    x[v] = leaf.vertex[ray.x][v] - ray.origin[ray.x] - ray.shear_x * z[v];
    y[v] = leaf.vertex[ray.y][v] - ray.origin[ray.y] - ray.shear_y * z[v];
  }
  for (uint32_t i = 0; leaf.present >> i; ++i) {
    const uint8_t a = leaf.corner[0][i], b = leaf.corner[1][i], c = leaf.corner[2][i];
    const float u = x[c] * y[b] - y[c] * x[b], v = x[a] * y[c] - y[a] * x[c], w = x[b] * y[a] - y[b] * x[a];
    if (std::min({u, v, w}) < 0 && std::max({u, v, w}) > 0) continue;
    const float area = u + v + w, t = ray.scale_z * (u / area * z[a] + v / area * z[b] + w / area * z[c]);
    if (t > ray.t_min && t <= ray.t_max) return true;  // not so if the area is 0
  }
  return false;
}

// Traces one ray through all that it meets, also behind the first hit: else children that come late would not be known.
class Trace {
 public:
  Trace(const WideTree& tree, std::vector<NodeVisits>& visits, const SampleRay& ray)
      : tree_(tree), visits_(visits), ray_(ray) {}

  struct Found {
    bool is_blocked;
    uint32_t steps;  // up to the first hit
  };
  Found node(uint32_t index) {
    const HierarchyNode& node = tree_.nodes[index];
    Found all{false, 1};
    ++steps_;
    for (uint32_t met = boxes_met(node, ray_); met != 0 && steps_ < kMostSteps; met &= met - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(met));
      const Found found = child(node.child[i]);
      Visits& visits = visits_[index][i];
      visits.blocked.fetch_add(found.is_blocked, std::memory_order_relaxed);
      visits.steps.fetch_add(found.steps, std::memory_order_relaxed);
      if (!all.is_blocked) all.steps += found.steps;
      all.is_blocked |= found.is_blocked;
    }
    return all;
  }

 private:
  Found child(uint32_t child) {
    if (!(child & kLeafChild)) return node(child);
    ++steps_;
    return {tree_.with_leaf(child, [&](const auto& leaf) { return is_blocked_by(leaf, ray_); }), 1};
  }

  const WideTree& tree_;
  std::vector<NodeVisits>& visits_;
  const SampleRay& ray_;
  uint32_t steps_ = 0;
};

// The best children first. A child that hardly any ray met stands between those that block and those that do not.
void sort_children(HierarchyNode& node, const NodeVisits& visits) {
  std::array<float, kNodeWidth> score;
  for (size_t i = 0; i < kNodeWidth; ++i) {
    const float least_cost = node.child[i] & kLeafChild ? 1 : 2;
    score[i] = (static_cast<float>(visits[i].blocked) + 0.5f) / (static_cast<float>(visits[i].steps) + least_cost);
    if (node.child[i] == kNoChild) score[i] = 0;
  }
  std::array<uint8_t, kNodeWidth> order;
  std::iota(order.begin(), order.end(), uint8_t{0});
  std::ranges::stable_sort(order, [&](uint8_t a, uint8_t b) { return score[a] > score[b]; });
  const HierarchyNode old = node;
  for (size_t i = 0; i < kNodeWidth; ++i) {
    for (size_t a = 0; a < 3; ++a) node.min[a][i] = old.min[a][order[i]], node.max[a][i] = old.max[a][order[i]];
    node.child[i] = old.child[order[i]];
  }
}

}  // namespace

void order_children(const PreparedMesh& mesh, WideTree& tree, const Bounds& box, Stop& stop) {
  const SampleRays rays(mesh, box);
  const auto count =
      static_cast<uint32_t>(std::min<uint64_t>(kMostRays, uint64_t{kRaysPerTriangle} * mesh.triangles.size()));
  std::vector<NodeVisits> visits(tree.nodes.size());
  tbb::parallel_for(tbb::blocked_range(0u, count, 64u), [&](const tbb::blocked_range<uint32_t>& range) {
    if (stop.now()) return;
    for (uint32_t i = range.begin(); i < range.end(); ++i) {
      const SampleRay ray = rays(i);
      Trace(tree, visits, ray).node(0);
    }
  });
  for (size_t i = 0; i < tree.nodes.size(); ++i) sort_children(tree.nodes[i], visits[i]);
}

}  // namespace vcd::baker
