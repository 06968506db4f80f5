#include "tree.h"

#include <algorithm>
#include <span>

#include "crown.h"
#include "foliage.h"
#include "tube.h"

namespace vcd::scenes {
namespace {

// A tree that is grown by its crown, and its leaves.
struct LeafySpecies {
  CrownShape shape;
  double leaf_length, leaf_width, leaf_fold;  // of a tree with kUsualLeaves
  double leaf_lean;                           // from the twig, in turns
  double leaf_droop;                          // how strongly leaves hang
};
constexpr double kUsualLeaves = 8000;

double rounded(double h) { return std::sqrt(std::max(0.0, 1 - (1.7 * h - 0.7) * (1.7 * h - 0.7))); }
double slender(double h) { return std::sqrt(std::max(0.0, 1 - (2 * h - 1) * (2 * h - 1))) * (1.15 - 0.55 * h); }
double domed(double h) { return std::sqrt(std::max(0.0, 1 - h * h)); }

constexpr LeafySpecies kBroadleaf = {{12, 2.6, 4.4, rounded, 1, 0.0, 0.12, 0.0095, 0.3}, 0.29, 0.18, 0.18, 0.17, 0.15};
constexpr LeafySpecies kBirch = {{13, 2.8, 2.1, slender, 1, 0.0, 0.35, 0.0065, 0.3}, 0.21, 0.13, 0.12, 0.19, 0.55};
constexpr LeafySpecies kShrub = {{2.5, 0.25, 1.7, domed, 7, 0.075, 0.1, 0.0042, 0.11}, 0.12, 0.06, 0.1, 0.13, -0.1};

uint32_t crown_points(uint32_t leaves) { return std::min(200 + leaves / 8, 4000u); }

// The trunk spreads where it enters the ground.
double flare(double height, double radius) {
  const double near = std::max(0.0, 1 - height / (4 * radius));
  return 1 + 0.7 * near * near;
}

// Each branch as one tube, from where it leaves a thicker one to its tip.
void append_wood(Mesh& mesh, std::span<const BranchNode> nodes) {
  std::vector<PathPoint> path;
  for (uint32_t i = 0; i < nodes.size(); ++i) {
    const BranchNode& parent = nodes[nodes[i].parent];
    const bool starts_at_root = parent.parent == nodes[i].parent;
    if (nodes[i].parent == i || (parent.thickest == i && !starts_at_root)) continue;
    path = {{parent.at, nodes[i].radius * (starts_at_root ? flare(0, nodes[i].radius) : 1)}};
    for (uint32_t n = i;; n = nodes[n].thickest) {
      const double widened = starts_at_root ? flare(nodes[n].at.y, nodes[i].radius) : 1;
      path.push_back({nodes[n].at, nodes[n].radius * widened});
      if (nodes[n].thickest == n) break;
    }
    append_tube(mesh, path, sides_for(nodes[i].radius));
  }
}

void append_leaves(Mesh& mesh, std::span<const BranchNode> nodes, const LeafySpecies& species, uint32_t leaves,
                   double scale, Random& random) {
  std::vector<uint32_t> twigs;
  const double thin = 2.3 * species.shape.tip_radius;
  for (uint32_t i = 0; i < nodes.size(); ++i)
    if (nodes[i].radius < thin && nodes[i].parent != i) twigs.push_back(i);
  for (uint32_t k = 0; k < leaves && !twigs.empty(); ++k) {
    const BranchNode& twig = nodes[twigs[uint64_t{k} * twigs.size() / leaves]];
    const Double3 from = nodes[twig.parent].at, axis = unit(twig.at - from);
    const double size = scale * random.uniform(0.7, 1.2), lean = species.leaf_lean * random.uniform(0.5, 1.3);
    Leaf leaf;
    leaf.base = mix(from, twig.at, random.uniform(0.1, 1));
    leaf.along = unit(leaning(axis, lean, random.uniform()) - species.leaf_droop * kUp);
    // Leaves turn their faces to the sky, more or less.
    leaf.across = unit(cross(leaf.along, kUp + 0.7 * random_direction(random)));
    leaf.base = leaf.base + (0.1 * size * species.leaf_length) * leaf.along;
    leaf.length = size * species.leaf_length;
    leaf.width = size * species.leaf_width;
    leaf.fold = -species.leaf_fold;
    append_leaf(mesh, leaf);
  }
}

// Twigs and leaves may hang below the foot of the trunk; the lowest point is to be the ground.
void stand_on_ground(Mesh& mesh) {
  float lowest = 0;
  for (const Vec3& p : mesh.positions) lowest = std::min(lowest, p[1]);
  for (Vec3& p : mesh.positions) p[1] -= lowest;  // exact: both are on the grid
}

void grow_leafy(Mesh& mesh, const LeafySpecies& species, uint32_t leaves, double leaf_scale, Random& random) {
  const std::vector<BranchNode> nodes = grow_crown(species.shape, crown_points(leaves), random);
  append_wood(mesh, nodes);
  append_leaves(mesh, nodes, species, leaves, leaf_scale, random);
}

}  // namespace

Mesh grow_tree(Species species, uint32_t leaves, uint64_t seed) {
  Random random(seed);
  const double leaf_scale = std::clamp(std::sqrt(kUsualLeaves / std::max(leaves, 1u)), 0.4, 2.5);
  Mesh mesh;
  switch (species) {
    case Species::broadleaf:
      mesh.name = "broadleaf";
      mesh.colour = {0.27f, 0.36f, 0.10f};
      grow_leafy(mesh, kBroadleaf, leaves, leaf_scale, random);
      break;
    case Species::conifer:
      mesh.name = "conifer";
      mesh.colour = {0.16f, 0.29f, 0.13f};
      grow_conifer(mesh, leaves, leaf_scale, random);
      break;
    case Species::birch:
      mesh.name = "birch";
      mesh.colour = {0.48f, 0.50f, 0.17f};
      grow_leafy(mesh, kBirch, leaves, leaf_scale, random);
      break;
    case Species::shrub:
      mesh.name = "shrub";
      mesh.colour = {0.42f, 0.27f, 0.14f};
      grow_leafy(mesh, kShrub, leaves, leaf_scale, random);
      break;
  }
  stand_on_ground(mesh);
  return mesh;
}

uint64_t tree_triangles_bound(uint32_t leaves) {
  const uint64_t nodes = uint64_t{4} * crown_points(leaves) + 64;
  const uint64_t leafy = uint64_t{2} * leaves + nodes * 2 * sides_for(1);
  return std::max(leafy, conifer_triangles_bound(leaves));
}

}  // namespace vcd::scenes
