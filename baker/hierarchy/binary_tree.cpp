#include "hierarchy/binary_tree.h"

#include <bit>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <vcd/format/hierarchy.h>

#include "hierarchy/both_sides.h"

namespace vcd::baker {
namespace {

constexpr uint32_t kBins = 16;
constexpr uint32_t kShared = 1u << 16;  // triangles of a node that threads look at together

struct Reference {
  Bounds box;
  uint32_t triangle;

  float centroid(size_t axis) const { return box.min[axis] + box.max[axis]; }  // twice, which is as good
};
using References = std::span<Reference>;

// Boxes around triangles, and around their centroids.
struct Extent {
  Box box = Box::of({}), centroids = box;

  void add(const Reference& r) {
    const Box own = Box::of(r.box);
    const Box::Lanes centroid = own.min + own.max;
    box.add(own), centroids.add(centroid, centroid);
  }
  void add(const Extent& other) { box.add(other.box), centroids.add(other.centroids); }
};

// Along one axis, from a centroid to its bin.
struct Binning {
  float origin = 0, scale = 0;

  Binning() = default;
  Binning(float min, float max) : origin(min), scale(kBins * 0.9999f / (max - min)) {}
  bool is_usable() const { return std::isfinite(scale); }  // false where centroids coincide
  uint32_t operator()(float centroid) const {
    return std::min(static_cast<uint32_t>((centroid - origin) * scale), kBins - 1);
  }
};

struct Bins {
  struct Bin {
    Box box = Box::of({});
    uint32_t count = 0;

    void add(const Bin& other) { box.add(other.box), count += other.count; }
  };
  Bin bins[3][kBins];

  void add(const Bins& other) {
    for (size_t axis = 0; axis < 3; ++axis)
      for (size_t i = 0; i < kBins; ++i) bins[axis][i].add(other.bins[axis][i]);
  }
};

// Sums `Sum::add` over references. The result does not depend on the order, and so not on the threads.
template <class Sum, class Add>
Sum sum_over(References references, const Add& add) {
  if (references.size() < kShared) {
    Sum sum;
    for (const Reference& r : references) add(sum, r);
    return sum;
  }
  using Range = tbb::blocked_range<size_t>;
  return tbb::parallel_reduce(
      Range(0, references.size(), kShared / 8), Sum(),
      [&](const Range& range, Sum sum) {
        for (size_t i = range.begin(); i < range.end(); ++i) add(sum, references[i]);
        return sum;
      },
      [](Sum a, const Sum& b) {
        a.add(b);
        return a;
      });
}

struct Split {
  size_t axis = 0;
  Binning binning;
  uint32_t left_bins = 0;  // bins of the left side
  float cost = Bounds::kInfinity;
};

// The cheapest split along one axis, if it beats `best`.
void improve(Split& best, size_t axis, const Binning& binning, const Bins::Bin (&bins)[kBins]) {
  float right_cost[kBins];  // of bins i and above; infinite for none
  Bins::Bin side;
  for (uint32_t i = kBins; i-- > 1;) {
    side.add(bins[i]);
    right_cost[i] = side.count > 0 ? side.box.half_area() * static_cast<float>(side.count) : Bounds::kInfinity;
  }
  side = {};
  for (uint32_t i = 1; i < kBins; ++i) {
    side.add(bins[i - 1]);
    if (side.count == 0) continue;
    const float cost = side.box.half_area() * static_cast<float>(side.count) + right_cost[i];
    if (cost < best.cost) best = {axis, binning, i, cost};
  }
}

// Nothing where all centroids coincide.
std::optional<Split> best_split(References references, const Box& centroids) {
  Binning binning[3];
  for (size_t a = 0; a < 3; ++a) binning[a] = {centroids.min[a], centroids.max[a]};
  const Bins bins = sum_over<Bins>(references, [&](Bins& sum, const Reference& r) {
    const Box box = Box::of(r.box);
    for (size_t a = 0; a < 3; ++a) {
      if (!binning[a].is_usable()) continue;
      Bins::Bin& bin = sum.bins[a][binning[a](r.centroid(a))];
      bin.box.add(box), ++bin.count;
    }
  });
  Split best;
  for (size_t a = 0; a < 3; ++a)
    if (binning[a].is_usable()) improve(best, a, binning[a], bins.bins[a]);
  return best.left_bins > 0 ? std::optional(best) : std::nullopt;
}

// Halves by number along the longest axis of the centroids. Returns the size of the left half.
uint32_t halve(References references, const Box& centroids) {
  size_t axis = 0;
  const auto length = [&](size_t a) { return centroids.max[a] - centroids.min[a]; };
  for (size_t a = 1; a < 3; ++a)
    if (length(a) > length(axis)) axis = a;
  const size_t half = references.size() / 2;
  std::nth_element(references.begin(), references.begin() + static_cast<ptrdiff_t>(half), references.end(),
                   [&](const Reference& a, const Reference& b) {
                     return std::pair(a.centroid(axis), a.triangle) < std::pair(b.centroid(axis), b.triangle);
                   });
  return static_cast<uint32_t>(half);
}

class Builder {
 public:
  Builder(std::span<Reference> references, std::vector<BinaryNode>& nodes, Stop& stop)
      : references_(references), nodes_(nodes), stop_(stop) {}

  void build(uint32_t node, uint32_t first, uint32_t count, uint32_t depth) {
    if (count >= kOwnTask && stop_.now()) return;
    const References own = references_.subspan(first, count);
    const Extent extent = sum_over<Extent>(own, [](Extent& sum, const Reference& r) { sum.add(r); });
    nodes_[node] = {extent.box.bounds(), first, count};
    if (count == 1) return;
    const uint32_t left_count = divide(own, extent.centroids, depth);
    const auto left = [&] { build(node + 1, first, left_count, depth + 1); };
    const auto right = [&] { build(node + 2 * left_count, first + left_count, count - left_count, depth + 1); };
    both_sides(count, left, right);
  }

 private:
  // Moves the left side to the front, and returns its size.
  static uint32_t divide(References references, const Box& centroids, uint32_t depth) {
    const auto levels_of_halving = static_cast<uint32_t>(std::bit_width(references.size() - 1));
    if (depth + levels_of_halving >= kMostLevels) return halve(references, centroids);
    const auto split = best_split(references, centroids);
    if (!split) return halve(references, centroids);
    const auto end = std::partition(references.begin(), references.end(), [&](const Reference& r) {
      return split->binning(r.centroid(split->axis)) < split->left_bins;
    });
    return static_cast<uint32_t>(end - references.begin());
  }

  const std::span<Reference> references_;
  std::vector<BinaryNode>& nodes_;
  Stop& stop_;
};

}  // namespace

BinaryTree build_binary_tree(const PreparedMesh& mesh, Stop& stop) {
  const auto count = static_cast<uint32_t>(mesh.triangles.size());
  std::vector<Reference> references(count);
  tbb::parallel_for(0u, count, [&](uint32_t t) {
    references[t].triangle = t;
    for (const uint32_t corner : mesh.triangles[t]) references[t].box.add(mesh.positions[corner]);
  });
  BinaryTree tree;
  tree.nodes.resize(2 * size_t{count} - 1);
  Builder(references, tree.nodes, stop).build(0, 0, count, 0);
  tree.triangles.reserve(count);
  for (const Reference& r : references) tree.triangles.push_back(r.triangle);
  return tree;
}

}  // namespace vcd::baker
