#include "crown.h"

#include <algorithm>
#include <numeric>

namespace vcd::scenes {
namespace {

constexpr double kKillSteps = 1.6;  // a point is reached when a branch comes so near, in steps
constexpr int kMaxRounds = 400;

struct Attractor {
  Double3 at;
  uint32_t nearest = 0;
  double distance2 = 1e30;
};

std::vector<Attractor> scatter(const CrownShape& shape, uint32_t points, Random& random) {
  std::vector<Attractor> attractors;
  while (attractors.size() < points) {
    const double h = random.uniform(), x = random.uniform(-1, 1), z = random.uniform(-1, 1);
    const double radius = shape.profile(h);
    if (x * x + z * z > radius * radius) continue;
    attractors.push_back(
        {{x * shape.crown_radius, shape.crown_base + h * (shape.height - shape.crown_base), z * shape.crown_radius}});
  }
  return attractors;
}

void raise_stems(const CrownShape& shape, Random& random, std::vector<BranchNode>& nodes) {
  nodes.push_back({{}, 0});
  const double turn = random.uniform();
  const auto segments = static_cast<uint32_t>(std::max(1.0, std::ceil(shape.crown_base / shape.step)));
  for (uint32_t s = 0; s < shape.stems; ++s) {
    const double away = turn + (s + random.uniform(-0.2, 0.2)) / shape.stems;
    Double3 direction = leaning(kUp, shape.stem_spread * random.uniform(0.7, 1.3), away);
    uint32_t tip = 0;
    for (uint32_t i = 0; i < std::min(segments, 60 / shape.stems); ++i) {
      direction = unit(direction + 0.06 * random_direction(random) + 0.05 * kUp);
      nodes.push_back({nodes[tip].at + shape.step * direction, tip});
      tip = static_cast<uint32_t>(nodes.size() - 1);
    }
  }
}

// A node that hangs between two points would put out the same shoot again and again.
bool grown_before(const std::vector<BranchNode>& nodes, const std::vector<std::vector<uint32_t>>& children,
                  uint32_t node, Double3 at, double step) {
  return std::any_of(children[node].begin(), children[node].end(), [&](uint32_t child) {
    const Double3 apart = nodes[child].at - at;
    return dot(apart, apart) < 0.04 * step * step;
  });
}

// Leonardo's rule, from the tips inwards.
void thicken(std::vector<BranchNode>& nodes, double tip_radius) {
  std::vector<double> section(nodes.size(), 0);
  for (size_t i = nodes.size(); i-- > 0;) {
    BranchNode& node = nodes[i];
    if (section[i] == 0) section[i] = tip_radius * tip_radius, node.thickest = static_cast<uint32_t>(i);
    node.radius = std::sqrt(section[i]);
    if (node.parent == i) continue;
    BranchNode& parent = nodes[node.parent];
    if (section[node.parent] == 0 || nodes[parent.thickest].radius <= node.radius)
      parent.thickest = static_cast<uint32_t>(i);
    section[node.parent] += section[i];
  }
}

// Takes out the zigzag that stepping leaves.
void smooth(std::vector<BranchNode>& nodes) {
  for (int pass = 0; pass < 2; ++pass) {
    const std::vector<BranchNode> old = nodes;
    for (uint32_t i = 1; i < nodes.size(); ++i) {
      if (old[i].thickest == i || old[i].parent == i) continue;
      nodes[i].at = mix(old[i].at, mix(old[old[i].parent].at, old[old[i].thickest].at, 0.5), 0.5);
    }
  }
}

}  // namespace

std::vector<BranchNode> grow_crown(const CrownShape& shape, uint32_t points, Random& random) {
  std::vector<Attractor> attractors = scatter(shape, points, random);
  std::vector<BranchNode> nodes;
  raise_stems(shape, random, nodes);
  std::vector<std::vector<uint32_t>> children(nodes.size());
  const size_t most = 4 * size_t{points} + 64;
  const double reached2 = kKillSteps * kKillSteps * shape.step * shape.step;
  uint32_t first_new = 0;
  for (int round = 0; round < kMaxRounds && first_new < nodes.size(); ++round) {
    for (Attractor& a : attractors) {
      for (uint32_t n = first_new; n < nodes.size(); ++n) {
        const Double3 apart = nodes[n].at - a.at;
        if (const double d2 = dot(apart, apart); d2 < a.distance2) a.distance2 = d2, a.nearest = n;
      }
    }
    std::erase_if(attractors, [&](const Attractor& a) { return a.distance2 < reached2; });
    first_new = static_cast<uint32_t>(nodes.size());

    std::vector<Double3> pull(nodes.size());
    for (const Attractor& a : attractors) pull[a.nearest] = pull[a.nearest] + unit(a.at - nodes[a.nearest].at);
    for (uint32_t n = 0; n < first_new && nodes.size() < most; ++n) {
      if (dot(pull[n], pull[n]) == 0) continue;
      const Double3 way = unit(pull[n]) + shape.rise * kUp + 0.15 * random_direction(random);
      const Double3 at = nodes[n].at + shape.step * unit(way);
      if (grown_before(nodes, children, n, at, shape.step)) continue;
      children[n].push_back(static_cast<uint32_t>(nodes.size()));
      nodes.push_back({at, n});
      children.emplace_back();
    }
  }
  thicken(nodes, shape.tip_radius);
  smooth(nodes);
  return nodes;
}

}  // namespace vcd::scenes
