#include "scene/placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "scene/trusted.h"

namespace vcd {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// In doubles, where products of three floats neither overflow nor underflow.
struct Affine {
  double m[3][3], t[3];

  explicit Affine(const Transform& transform) {
    for (size_t i = 0; i < 3; ++i) {
      for (size_t j = 0; j < 3; ++j) m[i][j] = transform.rows[i][j];
      t[i] = transform.rows[i][3];
    }
  }
  double cofactor(size_t i, size_t j) const {
    const size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
    return m[a][c] * m[b][d] - m[a][d] * m[b][c];
  }
};

float down(double x) { return std::nextafter(static_cast<float>(x), -kInfinity); }
float up(double x) { return std::nextafter(static_cast<float>(x), kInfinity); }

bool is_finite(const SceneInstance& instance, const Transform& to_world) {
  float sum = 0;
  for (int i = 0; i < 3; ++i) {
    for (float x : to_world.rows[i]) sum += x * 0;
    sum += instance.box_min[i] * 0 + instance.box_max[i] * 0;
  }
  return sum == 0;
}

// Limits within which segments that are trusted are taken to the grid and to the object's frame without overflow, and
// underflow does not matter.
constexpr float kLeastExtent = 0x1p-40f, kMostExtent = 0x1p40f;  // of the object's box, in its own frame
constexpr double kFarthestCentre = 0x1p100;
constexpr double kFarthestInGrid = 0x1p90;

// Nothing if the inverse is not known to the precision of floats: spec/proofs.md, "Scenes". Cofactors are rounded once,
// for products of two floats are exact in doubles.
std::optional<ToGrid> to_grid_of(const Affine& a, const SceneInstance& instance, const double (&centre)[3]) {
  double determinant = 0, most = 0;
  for (size_t j = 0; j < 3; ++j) {
    const double product = a.m[0][j] * a.cofactor(0, j);
    determinant += product, most += std::abs(product);
  }
  const double error = 0x1p-50 * (1 + most / std::abs(determinant));  // of the inverse, relative
  if (!(error <= 0x1p-26)) return std::nullopt;

  ToGrid grid{};
  bool usable = true;
  for (size_t i = 0; i < 3; ++i) {
    grid.centre[i] = static_cast<float>(centre[i]);
    const float extent = instance.box_max[i] - instance.box_min[i];
    usable &= extent >= kLeastExtent && extent <= kMostExtent && std::abs(centre[i]) <= kFarthestCentre;
  }
  const GridFrame frame = make_grid_frame(instance.box_min, instance.box_max);
  for (size_t i = 0; i < 3; ++i) {
    // The centre's own rounding goes into the offset: the object's point that stands exactly there.
    double offset = -double{frame.min[i]}, sum = std::abs(offset);
    for (size_t j = 0; j < 3; ++j) {
      const double inverse = a.cofactor(j, i) / determinant;
      const double part = inverse * (double{grid.centre[j]} - a.t[j]);
      grid.column[j][i] = static_cast<float>(inverse * double{frame.scale[i]});
      offset += part, sum += std::abs(part);
    }
    grid.offset[i] = static_cast<float>(offset * double{frame.scale[i]});
    usable &= error * sum * double{frame.scale[i]} <= 0x1p-12;
  }
  for (size_t j = 0; j < 3; ++j) {
    auto& column = grid.column[j];
    for (size_t i = 0; i < 3; ++i) column[3] += std::abs(column[i]);
    usable &= double{column[3]} * (double{kFarthest} + std::abs(centre[j])) <= kFarthestInGrid;
  }
  return usable ? std::optional(grid) : std::nullopt;
}

// Of boxes in the world, along one axis.
struct Range {
  double low = kInfinity, high = -kInfinity;

  // The box whose middle is at the sum of four numbers, of absolute values `sum` together.
  void add(double middle, double reach, double sum) {
    const double grown = reach + 0x1p-50 * (sum + reach) + kRoom;
    low = std::min(low, middle - grown), high = std::max(high, middle + grown);
  }
};

// Adds box k of the mesh, along axis i.
void add_box(const Affine& a, const BoxList& boxes, size_t k, size_t i, Range& range) {
  double middle = a.t[i], sum = std::abs(middle), reach = 0;
  for (size_t j = 0; j < 3; ++j) {
    const double part = a.m[i][j] * boxes.middle[j][k];
    middle += part, sum += std::abs(part);
    reach += std::abs(a.m[i][j]) * boxes.half[j][k];
  }
  range.add(middle, reach, sum);
}

Placed with_box(float low, float high, bool absent) {
  Placed placed{kNoInverse, {}, {}, {}, absent};
  std::fill_n(placed.low, 3, low), std::fill_n(placed.high, 3, high);
  return placed;
}

}  // namespace

MeshBoxes mesh_boxes(const ObjectRecord& record, const Traced& traced) {
  MeshBoxes boxes;
  constexpr float kGreatest = std::numeric_limits<float>::max();
  const auto add_to = [&](BoxList& list, const HierarchyNode& node, uint32_t child) {
    for (size_t a = 0; a < 3; ++a) {
      // In files that were only checked for bounds, boxes can be infinite or no numbers.
      const float min = std::min(std::max(-kGreatest, node.min[a][child]), kGreatest),
                  max = std::max(std::min(kGreatest, node.max[a][child]), -kGreatest);
      const double low = double{min} - (traced.min[a] - double{record.box_min[a]}),
                   high = double{max} + (record.box_max[a] - double{traced.max[a]});
      list.middle[a].push_back(0.5 * (low + high)), list.half[a].push_back(0.5 * (high - low));
    }
  };
  const auto for_children = [&](const HierarchyNode& node, const auto& f) {
    for (uint32_t k = 0; k < kNodeWidth && node.child[k] != kNoChild; ++k) f(node, k);
  };
  for_children(traced.view.node(kRootUnit), [&](const HierarchyNode& root, uint32_t k) {
    add_to(boxes.few, root, k);
    if (root.child[k] & kLeafChild) add_to(boxes.many, root, k);
    else
      for_children(traced.view.node(root.child[k]),
                   [&](const HierarchyNode& node, uint32_t i) { add_to(boxes.many, node, i); });
  });
  return boxes;
}

Placed place(const SceneInstance& instance, const MeshBoxes* boxes, const Transform& to_world) {
  const Placed everywhere = with_box(-kInfinity, kInfinity, false), nowhere = with_box(kInfinity, -kInfinity, true);
  for (int a = 0; a < 3; ++a)
    if (instance.box_min[a] > instance.box_max[a]) return nowhere;
  if (!is_finite(instance, to_world)) return everywhere;

  const Affine affine(to_world);
  double centre[3], extent = 0;
  Placed placed{};
  bool near = true;
  for (size_t i = 0; i < 3; ++i) {
    centre[i] = affine.t[i];
    double reach = 0, sum = std::abs(centre[i]);
    for (size_t j = 0; j < 3; ++j) {
      const double low = instance.box_min[j], high = instance.box_max[j], part = affine.m[i][j] * (0.5 * (low + high));
      centre[i] += part, sum += std::abs(part);
      reach += std::abs(affine.m[i][j]) * (0.5 * (high - low));
    }
    extent += reach;
    Range range;
    for (size_t k = 0; boxes && k < boxes->many.middle[i].size(); ++k) add_box(affine, boxes->many, k, i, range);
    if (!boxes) range.add(centre[i], reach, sum);
    placed.low[i] = down(range.low), placed.high[i] = up(range.high);
    placed.middle[i] = static_cast<float>(0.5 * (range.low + range.high));
    near &= placed.low[i] >= -kFarthest && placed.high[i] <= kFarthest;
  }
  if (extent == 0) return nowhere;
  if (!near) placed = everywhere;
  placed.to_grid = to_grid_of(affine, instance, centre).value_or(kNoInverse);
  return placed;
}

std::vector<WorldBox> boxes_in_world(const Placed& placed, const MeshBoxes& boxes, const Transform& to_world) {
  const Affine affine(to_world);
  std::vector<WorldBox> in_world(boxes.few.middle[0].size());
  for (size_t k = 0; k < in_world.size(); ++k)
    for (size_t i = 0; i < 3; ++i) {
      Range range;
      add_box(affine, boxes.few, k, i, range);
      in_world[k].low[i] = std::max(down(range.low), placed.low[i]);
      in_world[k].high[i] = std::min(up(range.high), placed.high[i]);
    }
  return in_world;
}

void pad_box(SceneInstance& instance) {
  float longest = 0;
  for (int a = 0; a < 3; ++a) longest = std::max(longest, instance.box_max[a] - instance.box_min[a]);
  for (int a = 0; a < 3; ++a) {
    const float extent = instance.box_max[a] - instance.box_min[a];
    if (!(extent >= 0)) continue;
    const float pad = std::max(extent, longest * 0x1p-6f) * 0x1p-10f;
    const float size = std::max(std::abs(instance.box_min[a]), std::abs(instance.box_max[a])) * 0x1p-22f;
    instance.box_min[a] -= pad + size, instance.box_max[a] += pad + size;
  }
}

}  // namespace vcd
