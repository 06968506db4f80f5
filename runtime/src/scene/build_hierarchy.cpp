#include "scene/build_hierarchy.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

namespace vcd {
namespace {

class Builder {
 public:
  Builder(std::span<const Placed> placed, std::vector<SceneNode>& nodes) : placed_(placed), nodes_(nodes) {}

  void build() {
    std::vector<uint32_t> order(placed_.size());
    std::iota(order.begin(), order.end(), 0u);
    nodes_.clear();
    if (!order.empty()) add(order);
  }

 private:
  uint32_t add(std::span<uint32_t> order) {
    const auto at = static_cast<uint32_t>(nodes_.size());
    nodes_.emplace_back();
    std::array<std::span<uint32_t>, 8> parts;
    parts[0] = order;
    size_t count = 1;
    for (int round = 0; round < 3; ++round)
      for (size_t k = count; k-- > 0;)
        if (parts[k].size() > 1) {
          const size_t half = split(parts[k]);
          parts[count++] = parts[k].subspan(half);
          parts[k] = parts[k].first(half);
        }
    for (size_t k = 0; k < 8; ++k) {
      float low[3], high[3];
      std::fill_n(low, 3, std::numeric_limits<float>::infinity());
      std::fill_n(high, 3, -std::numeric_limits<float>::infinity());
      for (uint32_t i : k < count ? parts[k] : std::span<uint32_t>{})
        for (int a = 0; a < 3; ++a)
          low[a] = std::min(low[a], placed_[i].low[a]), high[a] = std::max(high[a], placed_[i].high[a]);
      const uint32_t child = k >= count ? kLeaf : parts[k].size() == 1 ? kLeaf | parts[k][0] : add(parts[k]);
      SceneNode& node = nodes_[at];
      for (int a = 0; a < 3; ++a) node.low[a][k] = low[a], node.high[a][k] = high[a];
      node.child[k] = child;
    }
    return at;
  }

  size_t split(std::span<uint32_t> order) {
    const auto centre = [&](uint32_t i, int a) { return placed_[i].middle[a]; };
    int axis = 0;
    float widest = -1;
    for (int a = 0; a < 3; ++a) {
      float low = centre(order[0], a), high = low;
      for (uint32_t i : order) low = std::min(low, centre(i, a)), high = std::max(high, centre(i, a));
      if (high - low > widest) widest = high - low, axis = a;
    }
    const size_t half = order.size() / 2;
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                     [&](uint32_t x, uint32_t y) {
                       return centre(x, axis) != centre(y, axis) ? centre(x, axis) < centre(y, axis) : x < y;
                     });
    return half;
  }

  std::span<const Placed> placed_;
  std::vector<SceneNode>& nodes_;
};

}  // namespace

std::vector<SceneNode> build_hierarchy(std::span<const Placed> placed) {
  std::vector<SceneNode> nodes;
  Builder(placed, nodes).build();
  return nodes;
}

}  // namespace vcd
