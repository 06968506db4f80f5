#include "hierarchy/look_up_worth.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <vcd/baker/audit.h>
#include <vcd/format/line_cell.h>
#include <vcd/format/meets.h>
#include <vcd/format/wide_ray.h>

#include "classify/random.h"

namespace vcd::baker {
namespace {

constexpr size_t kSegments = 4096;
// What is near a side of a box, as a share of its extent.
constexpr float kNearSide = 0x1p-5f;
// Of a look-up in an array, in nodes and leaves: 17 ns against 25 to 30 (spec/results.md, "Hierarchies").
constexpr double kLookUpSteps = 0.65;
// What saves less is left as it would be without look-ups.
constexpr double kWorthwhile = 0.97;
// A node of a bundle serves many of its segments.
constexpr double kLookUpStepsTogether = 2 * kLookUpSteps;
// One by one, scattered segments wait for a tree's memory (likewise, "Looked up or not").
constexpr double kLookUpStepsOfOne = 3;

// The nodes and leaves up to the first hit.
class Steps {
 public:
  Steps(const HierarchyView& view, const Segment& segment) : view_(view), segment_(segment), ray_(segment) {
    below(kRootUnit);
  }
  uint64_t count() const { return steps_; }

 private:
  bool below(uint32_t unit) {  // whether something is hit
    ++steps_;
    const HierarchyNode& node = view_.node(unit);
    for (size_t i = 0; i < kNodeWidth && node.child[i] != kNoChild; ++i) {
      if (!ray_.may_meet([&](size_t a) { return static_cast<double>(node.min[a][i]); },
                         [&](size_t a) { return static_cast<double>(node.max[a][i]); }))
        continue;
      if (node.child[i] & kLeafChild ? leaf(node.child[i]) : below(node.child[i])) return true;
    }
    return false;
  }
  bool leaf(uint32_t child) {
    ++steps_;
    return with_leaf(view_, child, [&](const auto& leaf) {
      for (size_t i = 0; leaf.present >> i & 1; ++i) {
        Triangle triangle;
        for (size_t k = 0; k < 3; ++k)
          for (size_t a = 0; a < 3; ++a) triangle[k][a] = leaf.vertex[a][leaf.corner[k][i]];
        if (meets(segment_, triangle)) return true;
      }
      return false;
    });
  }

  const HierarchyView view_;
  const Segment& segment_;
  const WideRay ray_;
  uint64_t steps_ = 0;
};

struct Worth {
  bool in_array = false, together = false, one = false;
};
Worth worth_of(const std::vector<AskedSegment>& segments, const GridFrame& frame, const TreeView& tree,
               const HierarchyView& hierarchy) {
  double all = 0, left = 0, weights = 0;
  for (const auto& [segment, weight] : segments) {
    const double steps = weight * static_cast<double>(Steps(hierarchy, segment).count());
    all += steps, weights += weight;
    if (classify(frame, tree, tree.shape, segment) == Visibility::unclassified) left += steps;
  }
  if (weights == 0) return {};
  return {left + kLookUpSteps * weights <= kWorthwhile * all, left + kLookUpStepsTogether * weights <= all,
          left + kLookUpStepsOfOne * weights <= all};
}

// Lines from all around, and segments of the same directions from points of the box. Every other one begins near a side
// of the box and leads away from it: most surfaces in an object's box are of what it stands on or leans against.
void add_any(const PreparedMesh& mesh, std::vector<AskedSegment>& outside, std::vector<AskedSegment>& inside) {
  uint64_t counter = 0;
  for (Segment s : audit_segments(mesh, AuditKind::chords, 1, kSegments)) {
    outside.push_back({s, 1});
    for (int a = 0; a < 3; ++a) {
      const auto share = static_cast<float>(mix_bits(kGolden * ++counter) >> 40) * 0x1p-24f;
      s.origin[a] = mesh.box_min[a] + share * (mesh.box_max[a] - mesh.box_min[a]);
    }
    if (inside.size() % 2 != 0) {
      const auto side = static_cast<uint32_t>(mix_bits(kGolden * ++counter) >> 40) % 6;
      const auto a = side / 2;
      const float depth = (s.origin[a] - mesh.box_min[a]) * kNearSide;
      s.origin[a] = side % 2 == 0 ? mesh.box_min[a] + depth : mesh.box_max[a] - depth;
      s.direction[a] = side % 2 == 0 ? std::abs(s.direction[a]) : -std::abs(s.direction[a]);
    }
    inside.push_back({s, 1});
  }
}

// Some of those that are asked, evenly.
void add_asked(std::span<const AskedSegment> asked, const GridFrame& frame, std::vector<AskedSegment>& outside,
               std::vector<AskedSegment>& inside) {
  const size_t step = asked.size() / kSegments + 1;
  for (size_t i = 0; i < asked.size(); i += step)
    (asked[i].segment.t_min > locate(frame, asked[i].segment).t_entry ? inside : outside).push_back(asked[i]);
}

}  // namespace

uint16_t look_up_worth(const PreparedMesh& mesh, const ObjectRecord& record, const TreeView& tree,
                       const HierarchyView& hierarchy, std::span<const AskedSegment> asked) {
  if (!hierarchy || record.method == static_cast<uint8_t>(Method::none)) return 0;
  const GridFrame frame = make_grid_frame(record.box_min, record.box_max);
  TreeView trusted = tree;  // as renderers do unless they are told otherwise
  trusted.answers = answer_table(
      record.method == static_cast<uint8_t>(Method::hybrid) ? Trust::statistics : Trust::proofs, classes_in(record));
  std::vector<AskedSegment> outside, inside;
  if (asked.empty()) add_any(mesh, outside, inside);
  else add_asked(asked, frame, outside, inside);
  const Worth from_outside = worth_of(outside, frame, trusted, hierarchy),
              from_inside = worth_of(inside, frame, trusted, hierarchy);
  const auto flag = [](bool is_set, uint16_t bit) { return is_set ? bit : uint16_t{0}; };
  return static_cast<uint16_t>(
      flag(from_outside.in_array, kLookUpFromOutside) | flag(from_inside.in_array, kLookUpFromInside) |
      flag(from_outside.together, kLookUpTogetherFromOutside) | flag(from_inside.together, kLookUpTogetherFromInside) |
      flag(from_outside.one, kLookUpOneFromOutside) | flag(from_inside.one, kLookUpOneFromInside));
}

}  // namespace vcd::baker
