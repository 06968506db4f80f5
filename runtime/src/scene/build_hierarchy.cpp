#include "scene/build_hierarchy.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace vcd {
namespace {

constexpr size_t kBins = 16;
// From this level on parts are halved by number: sixteen to the power of the rest is more than there are instances.
constexpr size_t kHalvedFrom = kMostSceneLevels - 8;

struct Bounds {
  float low[3], high[3];

  Bounds() {
    std::fill_n(low, 3, std::numeric_limits<float>::infinity());
    std::fill_n(high, 3, -std::numeric_limits<float>::infinity());
  }
  template <class Box>  // with low and high
  void add(const Box& box) {
    for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], box.low[a]), high[a] = std::max(high[a], box.high[a]);
  }
  // Half the surface: 0 of an empty box, infinite or no number where the box is infinite.
  double area() const {
    double e[3];
    for (int a = 0; a < 3; ++a) e[a] = std::max(0.0, double{high[a]} - low[a]);
    return e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
  }
};

class Builder {
 public:
  Builder(std::span<const Placed> placed, const BoxesOf& boxes_of, std::vector<SceneNode>& nodes)
      : placed_(placed), boxes_of_(boxes_of), nodes_(nodes) {}

  void build() {
    std::vector<uint32_t> all(placed_.size());
    std::iota(all.begin(), all.end(), 0u);
    nodes_.clear();
    if (!all.empty()) add(all, 0);
  }

 private:
  using Instances = std::span<uint32_t>;
  struct Part {
    Instances instances;
    Bounds box;
  };
  // Some of the boxes of an instance, which is a part by itself.
  struct Piece {
    uint32_t instance;
    std::vector<WorldBox> boxes;
    Bounds box;
  };
  struct Bin {
    Bounds box;
    size_t count = 0;
  };
  struct Split {
    int axis;
    float from, to;  // middles on the axis
    size_t bins;     // of the first side
    double cost = std::numeric_limits<double>::infinity();

    size_t bin(float middle) const {
      return std::min(static_cast<size_t>((middle - from) / (to - from) * float{kBins}), kBins - 1);
    }
  };

  uint32_t add(Instances instances, size_t level) {
    assert(level < kMostSceneLevels);
    const auto at = static_cast<uint32_t>(nodes_.size());
    nodes_.emplace_back();
    std::array<Part, kBoxes> parts;
    size_t count = 0;
    parts[count++] = part_of(instances);
    while (count < kBoxes) {
      // The greatest that can be split.
      Part* greatest = nullptr;
      double most = -1;
      for (Part& part : std::span(parts).first(count)) {
        const auto number = static_cast<double>(part.instances.size());
        const double size = level < kHalvedFrom && std::isfinite(part.box.area()) ? part.box.area() : number;
        if (number > 1 && size > most) most = size, greatest = &part;
      }
      if (!greatest) break;
      const size_t half = split(greatest->instances, level);
      parts[count++] = part_of(greatest->instances.subspan(half));
      *greatest = part_of(greatest->instances.first(half));
    }
    std::array<Bounds, kBoxes> boxes;
    std::array<uint32_t, kBoxes> children;
    children.fill(kLeaf);
    if (count < kBoxes) {  // all parts are one instance each
      const std::vector<Piece> pieces = pieces_of(std::span(parts).first(count), level == 0);
      for (size_t k = 0; k < pieces.size(); ++k) {
        const bool again = k + 1 < pieces.size() && pieces[k + 1].instance == pieces[k].instance;
        boxes[k] = pieces[k].box, children[k] = kLeaf | (again ? kAgain : 0) | pieces[k].instance;
      }
    } else {
      for (size_t k = 0; k < kBoxes; ++k) {
        const Instances of = parts[k].instances;
        boxes[k] = parts[k].box, children[k] = of.size() == 1 ? kLeaf | of[0] : add(of, level + 1);
      }
    }
    SceneNode& node = nodes_[at];
    for (size_t k = 0; k < kBoxes; ++k) {
      for (int a = 0; a < 3; ++a) node.side[0][a][k] = boxes[k].low[a], node.side[1][a][k] = boxes[k].high[a];
      node.child[k] = children[k];
    }
    return at;
  }

  // A box for each instance; with `several`, those that are smaller together than it in its place, as many as there is
  // room for, side by side.
  std::vector<Piece> pieces_of(std::span<const Part> parts, bool several) const {
    std::vector<Piece> pieces;
    for (const Part& part : parts) {
      Piece piece{part.instances[0], {}, part.box};
      if (several && part.box.area() > 0 && std::isfinite(part.box.area())) piece.boxes = boxes_of_(piece.instance);
      double sum = 0;
      for (const WorldBox& box : piece.boxes) sum += around({&box, 1}).area();
      if (!(sum < part.box.area())) piece.boxes.clear();
      pieces.push_back(std::move(piece));
    }
    while (pieces.size() < kBoxes) {
      const auto size = [](const Piece& piece) { return piece.boxes.size() > 1 ? piece.box.area() : -1; };
      const auto greatest =
          std::ranges::max_element(pieces, [&](const Piece& a, const Piece& b) { return size(a) < size(b); });
      if (greatest->boxes.size() < 2) break;
      Piece rest = split(*greatest);
      pieces.insert(greatest + 1, std::move(rest));
    }
    return pieces;
  }

  static Bounds around(std::span<const WorldBox> boxes) {
    Bounds bounds;
    for (const WorldBox& box : boxes) bounds.add(box);
    return bounds;
  }

  // Takes those boxes away that, by the middles on some axis, are best enclosed by themselves.
  static Piece split(Piece& piece) {
    const size_t count = piece.boxes.size();
    const auto sort_by = [&](int a) {
      std::ranges::stable_sort(piece.boxes, [&](const WorldBox& x, const WorldBox& y) {
        return x.low[a] + x.high[a] < y.low[a] + y.high[a];
      });
    };
    const auto from = [&](size_t first, size_t end) {
      return around(std::span(piece.boxes).subspan(first, end - first));
    };
    int best_axis = 0;
    size_t best = 1;
    double least = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
      sort_by(a);
      for (size_t k = 1; k < count; ++k)
        if (const double sum = from(0, k).area() + from(k, count).area(); sum < least)
          least = sum, best_axis = a, best = k;
    }
    sort_by(best_axis);
    Piece rest{piece.instance, {piece.boxes.begin() + static_cast<std::ptrdiff_t>(best), piece.boxes.end()}, {}};
    rest.box = from(best, count);
    piece.box = from(0, best);
    piece.boxes.resize(best);
    return rest;
  }

  Part part_of(Instances instances) const {
    Part part{instances, {}};
    for (uint32_t i : instances) part.box.add(placed_[i]);
    return part;
  }

  // Orders at least two instances so that those of the first side come first; returns how many these are.
  size_t split(Instances instances, size_t level) const {
    float from[3], to[3];
    for (int a = 0; a < 3; ++a) {
      from[a] = to[a] = placed_[instances[0]].middle[a];
      for (uint32_t i : instances)
        from[a] = std::min(from[a], placed_[i].middle[a]), to[a] = std::max(to[a], placed_[i].middle[a]);
    }
    if (level < kHalvedFrom)
      if (const Split best = best_split(instances, from, to); std::isfinite(best.cost)) {
        const auto end = std::partition(instances.begin(), instances.end(),
                                        [&](uint32_t i) { return best.bin(placed_[i].middle[best.axis]) < best.bins; });
        return static_cast<size_t>(end - instances.begin());
      }
    int axis = 0;
    for (int a = 1; a < 3; ++a)
      if (to[a] - from[a] > to[axis] - from[axis]) axis = a;
    const size_t half = instances.size() / 2;
    std::nth_element(instances.begin(), instances.begin() + static_cast<std::ptrdiff_t>(half), instances.end(),
                     [&](uint32_t x, uint32_t y) {
                       const float p = placed_[x].middle[axis], q = placed_[y].middle[axis];
                       return p != q ? p < q : x < y;
                     });
    return half;
  }

  // Of infinite cost if there is none.
  Split best_split(Instances instances, const float (&from)[3], const float (&to)[3]) const {
    Split best{};
    for (int a = 0; a < 3; ++a) {
      Split split{a, from[a], to[a], 0};
      if (!(to[a] - from[a] > 0 && std::isfinite(to[a] - from[a]))) continue;
      std::array<Bin, kBins> bins;
      for (uint32_t i : instances) {
        Bin& bin = bins[split.bin(placed_[i].middle[a])];
        bin.box.add(placed_[i]), ++bin.count;
      }
      double behind[kBins];  // cost of this bin and those after it
      const auto cost = [](const Bin& side) { return side.box.area() * static_cast<double>(side.count); };
      const auto join = [](Bin& side, const Bin& bin) { side.box.add(bin.box), side.count += bin.count; };
      Bin side;
      for (size_t b = kBins; b-- > 1;) join(side, bins[b]), behind[b] = cost(side);
      side = {};
      for (split.bins = 1; split.bins < kBins; ++split.bins) {
        join(side, bins[split.bins - 1]);
        if (side.count == 0 || side.count == instances.size()) continue;
        split.cost = cost(side) + behind[split.bins];
        if (split.cost < best.cost) best = split;
      }
    }
    return best;
  }

  std::span<const Placed> placed_;
  const BoxesOf& boxes_of_;
  std::vector<SceneNode>& nodes_;
};

}  // namespace

std::vector<SceneNode> build_hierarchy(std::span<const Placed> placed, const BoxesOf& boxes_of) {
  std::vector<SceneNode> nodes;
  Builder(placed, boxes_of, nodes).build();
  return nodes;
}

}  // namespace vcd
