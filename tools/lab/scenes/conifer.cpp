// A spruce: whorls of branches about a straight trunk, drooping below and rising above, their ends turned up, each a
// flat spray of twigs hung with needles.
#include <algorithm>
#include <vector>

#include "foliage.h"
#include "tube.h"

namespace vcd::scenes {
namespace {

constexpr double kHeight = 14, kFirstWhorl = 1.1, kSpread = 2.7, kTrunkRadius = 0.17;
constexpr int kWhorls = 34, kBranchesPerWhorl = 6, kBranchPoints = 7, kTwigsPerBranch = 10, kTrunkPoints = 24;

struct Twig {
  Double3 from, to;
};

double trunk_radius(double height) { return 0.012 + kTrunkRadius * (1 - height / kHeight); }

void append_trunk(Mesh& mesh, Random& random) {
  std::vector<PathPoint> path;
  for (int i = 0; i < kTrunkPoints; ++i) {
    const double height = kHeight * i / (kTrunkPoints - 1);
    const double sway = i == 0 ? 0 : 0.02;
    path.push_back({Double3{sway * random.uniform(-1, 1), height, sway * random.uniform(-1, 1)}, trunk_radius(height)});
  }
  path[0].radius *= 1.5;
  append_tube(mesh, path, sides_for(kTrunkRadius));
}

// One branch and its twigs; the twigs are returned for the needles.
void append_branch(Mesh& mesh, double height, double turn, double reach, Random& random, std::vector<Twig>& twigs) {
  const CosSin t = at_turn(turn);
  const Double3 out = {t.cos, 0, t.sin}, aside = {-t.sin, 0, t.cos};
  const double relative = height / kHeight;
  const double rise = 0.75 * relative - 0.42 + random.uniform(-0.08, 0.08);  // slope at the trunk
  const double upturn = 0.28 * (1 - relative);                               // of the end
  const double bend = random.uniform(-0.1, 0.1);
  const auto at = [&](double u) {
    return Double3{0, height, 0} + (reach * u) * out + (reach * (rise * u + upturn * u * u * u)) * kUp +
           (reach * bend * u * u) * aside;
  };
  const double thickness = 0.008 + 0.009 * reach;
  std::vector<PathPoint> path;
  for (int i = 0; i < kBranchPoints; ++i) {
    const double u = static_cast<double>(i) / (kBranchPoints - 1);
    path.push_back({at(u), thickness * (1 - 0.8 * u)});
  }
  append_tube(mesh, path, 4);
  for (int i = 0; i < kTwigsPerBranch; ++i) {
    const double u = 0.16 + 0.8 * (i + random.uniform(0, 0.8)) / kTwigsPerBranch;
    const double side = i % 2 == 0 ? 1 : -1, span = reach * (0.42 - 0.30 * u) + 0.06;
    const double spread = side * random.uniform(0.8, 1.2), droop = random.uniform(0.1, 0.4);
    const Double3 way = unit(out + spread * aside - droop * kUp);
    twigs.push_back({at(u), at(u) + span * random.uniform(0.8, 1.15) * way});
    const Double3 sag = mix(twigs.back().from, twigs.back().to, 0.5) + 0.04 * span * kUp;
    append_tube(mesh, std::vector<PathPoint>{{twigs.back().from, 0.006}, {sag, 0.005}, {twigs.back().to, 0.003}}, 3);
  }
  twigs.push_back({at(0.55), at(1)});
}

void append_needles(Mesh& mesh, const Twig& twig, double along, double scale, Random& random) {
  const Double3 axis = unit(twig.to - twig.from);
  Leaf leaf;
  leaf.base = mix(twig.from, twig.to, along);
  const double lean = random.uniform(0.04, 0.13), turn = random.uniform();
  leaf.along = unit(leaning(axis, lean, turn) - 0.25 * kUp);
  leaf.across = unit(cross(leaf.along, kUp + 0.8 * random_direction(random)));
  leaf.length = scale * random.uniform(0.24, 0.38);
  leaf.width = scale * random.uniform(0.075, 0.105);
  leaf.fold = -0.2;
  append_leaf(mesh, leaf);
}

}  // namespace

void grow_conifer(Mesh& mesh, uint32_t leaves, double leaf_scale, Random& random) {
  append_trunk(mesh, random);
  std::vector<Twig> twigs;
  for (int w = 0; w < kWhorls; ++w) {
    const double u = static_cast<double>(w) / (kWhorls - 1), turn = random.uniform();
    const double height = kFirstWhorl + (kHeight - 0.35 - kFirstWhorl) * u;
    const double reach = 0.16 + kSpread * (1 - u) * (0.75 + 0.25 * (1 - u));
    for (int b = 0; b < kBranchesPerWhorl; ++b) {
      const double place = height + random.uniform(-0.1, 0.1);
      const double away = turn + (b + random.uniform(-0.25, 0.25)) / kBranchesPerWhorl;
      append_branch(mesh, place, away, reach * random.uniform(0.78, 1.08), random, twigs);
    }
  }
  twigs.push_back({{0, kHeight - 0.9, 0}, {0, kHeight + 0.1, 0}});

  // Needles in proportion to the twigs' lengths.
  std::vector<double> ends;
  double total = 0;
  for (const Twig& twig : twigs) ends.push_back(total += length(twig.to - twig.from));
  for (uint32_t k = 0; k < leaves; ++k) {
    const double at = total * (k + random.uniform()) / leaves;
    const size_t i = std::min<size_t>(std::lower_bound(ends.begin(), ends.end(), at) - ends.begin(), twigs.size() - 1);
    const double start = i == 0 ? 0 : ends[i - 1];
    append_needles(mesh, twigs[i], (at - start) / (ends[i] - start), leaf_scale, random);
  }
}

uint64_t conifer_triangles_bound(uint32_t leaves) {
  const uint64_t branch = 2 * 4 * (kBranchPoints - 1) + kTwigsPerBranch * 2 * 3 * 2;
  return uint64_t{2} * leaves + kWhorls * kBranchesPerWhorl * branch + 2 * sides_for(1) * (kTrunkPoints - 1);
}

}  // namespace vcd::scenes
