#include <algorithm>
#include <map>

#include <vcd/scenes/generate.h>

#include "setting.h"
#include "tree.h"

namespace vcd::scenes {
namespace {

// The ground plan: the camera stands over the origin and looks along -z; `ahead` is the distance from it. The trees
// fill a wedge somewhat wider than what it sees, but for a winding glade that leads in.
constexpr double kFirstTree = 17;
constexpr double kCameraHeight = 9.5;

double half_width(double ahead) { return 7 + 0.56 * ahead; }
double glade_middle(double ahead) { return 5.5 * at_turn(ahead / 90 + 0.12).sin - 3; }
double glade_half_width(double ahead) { return std::max(0.0, 4.2 - 0.035 * ahead); }

struct Kind {
  Mesh mesh;
  double crown_radius, height;
};

Kind grow_kind(uint32_t species, uint32_t leaves, uint64_t seed) {
  Kind kind{grow_tree(static_cast<Species>(species), leaves, seed), 0, 0};
  for (const auto& [x, y, z] : kind.mesh.positions) {
    kind.crown_radius = std::max(kind.crown_radius, std::sqrt(double{x} * x + double{z} * z));
    kind.height = std::max<double>(kind.height, y);
  }
  return kind;
}

struct Tree {
  uint32_t kind;
  double x, z, scale, crown_radius;
};

// Dart throwing: a tree is placed where it keeps its distance from all that stand already.
class Planting {
 public:
  Planting(uint32_t trees, const std::vector<Kind>& kinds) {
    for (const Kind& kind : kinds) cell_ = std::max(cell_, 2 * kTrunkDistance * kMaxTreeScale * kind.crown_radius);
    double area = 0;  // that one tree needs, with room to spare: darts find no place in a full wood
    const auto kind_count = static_cast<double>(kinds.size());
    for (const Kind& kind : kinds) area += 1.9 * kind.crown_radius * kind.crown_radius / kind_count;
    last_ = kFirstTree + 6;
    while ((last_ - kFirstTree) * (half_width(last_) + half_width(kFirstTree)) < area * trees) last_ += 1;
  }

  Tree plant(uint32_t kind, double scale, double crown_radius, Random& random) {
    for (uint32_t failures = 0;; ++failures) {
      if (failures % 64 == 63) last_ *= 1.02;  // it is too full: let the wood grow deeper
      const double ahead = random.uniform(kFirstTree, last_), side = random.uniform(-1, 1) * half_width(last_);
      const Tree tree{kind, side, -ahead, scale, crown_radius};
      if (std::fabs(side) > half_width(ahead) || in_glade(tree) || crowded(tree)) continue;
      cells_[cell_of(tree.x, tree.z)].push_back(tree);
      return tree;
    }
  }

  double last() const { return last_; }

  static constexpr double kMaxTreeScale = 1.2;
  static constexpr double kTrunkDistance = 0.6;  // of the sum of two crown radii

 private:
  using Cell = std::pair<int64_t, int64_t>;
  Cell cell_of(double x, double z) const {
    return {static_cast<int64_t>(std::floor(x / cell_)), static_cast<int64_t>(std::floor(z / cell_))};
  }

  static bool in_glade(const Tree& tree) {
    return std::fabs(tree.x - glade_middle(-tree.z)) < glade_half_width(-tree.z) + 0.5 * tree.crown_radius;
  }

  bool crowded(const Tree& tree) const {
    const auto [cx, cz] = cell_of(tree.x, tree.z);
    for (int64_t x = cx - 1; x <= cx + 1; ++x) {
      for (int64_t z = cz - 1; z <= cz + 1; ++z) {
        const auto found = cells_.find({x, z});
        if (found == cells_.end()) continue;
        for (const Tree& other : found->second) {
          const double dx = other.x - tree.x, dz = other.z - tree.z;
          const double apart = kTrunkDistance * (tree.crown_radius + other.crown_radius);
          if (dx * dx + dz * dz < apart * apart) return true;
        }
      }
    }
    return false;
  }

  double cell_ = 1, last_;
  std::map<Cell, std::vector<Tree>> cells_;
};

Instance instance_of(const Tree& tree, double turn) {
  const CosSin t = at_turn(turn);
  const auto c = static_cast<float>(tree.scale * t.cos), s = static_cast<float>(tree.scale * t.sin);
  const Vec3 at = on_grid({tree.x, 0, tree.z});
  return {tree.kind, {c, 0, s, at[0], 0, static_cast<float>(tree.scale), 0, at[1], -s, 0, c, at[2]}};
}

// Two large lights above the wood, the stronger one behind the camera's left shoulder.
void light_up(Scene& scene, double top, double last) {
  const double reach = last - kFirstTree, side = 0.18 * reach + 3;
  const Double3 middle = {0, 0, -kFirstTree - 0.3 * reach};
  const Double3 above = middle + (top + 0.4 * reach + 6) * kUp;
  scene.lights = {square_light(above + Double3{-0.35 * reach, 0, 0.3 * reach}, side, middle, {1.5, 1.38, 1.2}),
                  square_light(above + Double3{0.4 * reach, 0, -0.3 * reach}, side, middle, {0.6, 0.66, 0.75})};
}

}  // namespace

uint64_t forest_mesh_triangles_bound(const ForestOptions& options) {
  return std::clamp(options.species, 1u, kSpeciesCount) * tree_triangles_bound(options.leaves);
}

Scene forest(const ForestOptions& options) {
  const uint32_t species = std::clamp(options.species, 1u, kSpeciesCount);
  Random random(options.seed);
  std::vector<Kind> kinds;
  for (uint32_t s = 0; s < species; ++s) kinds.push_back(grow_kind(s, options.leaves, random.bits()));

  Scene scene;
  scene.name = "forest";
  Planting planting(options.instances, kinds);
  double top = 0;
  for (uint32_t i = 0; i < options.instances; ++i) {
    const uint32_t kind = i < species ? i : static_cast<uint32_t>(random.uniform() * species);
    const double scale = random.uniform(0.7, Planting::kMaxTreeScale);
    const Tree tree = planting.plant(kind, scale, scale * kinds[kind].crown_radius, random);
    scene.instances.push_back(instance_of(tree, random.uniform()));
    top = std::max(top, scale * kinds[kind].height);
  }
  for (Kind& kind : kinds) scene.meshes.push_back(std::move(kind.mesh));

  const double last = planting.last();
  scene.ground = {0, 0, static_cast<float>(-0.5 * last), static_cast<float>(4 * last), {0.28f, 0.25f, 0.17f}};
  scene.camera.position = to_float({glade_middle(0), kCameraHeight, 0});
  scene.camera.target = to_float({glade_middle(30), 2.2, -30});
  scene.camera.vertical_fov_degrees = 38;
  light_up(scene, top, last);
  return scene;
}

}  // namespace vcd::scenes
