// What queries of a scene need.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <vcd/format/line_cell.h>
#include <vcd/runtime/scene.h>

#include "object_data.h"

namespace vcd {

// An instance's transform from the world to its object's grid: grid = Σ column[a] · (world − centre)[a] + offset, in
// the first three of four.
struct alignas(16) ToGrid {
  float centre[4];     // the fourth is 0
  float column[3][4];  // the fourth is the sum of the others' absolute values: what rounding has to do with each
                       // coordinate
  float offset[4];     // the fourth is 0
};
// A segment of the world in an instance's grid.
inline Segment in_grid(const ToGrid& grid, const Segment& world) {
  float o[3];
  for (int a = 0; a < 3; ++a) o[a] = world.origin[a] - grid.centre[a];
  const float* d = world.direction;
  Segment segment{{}, world.t_min, {}, world.t_max};
  for (int i = 0; i < 3; ++i) {
    const auto& c = grid.column;
    segment.origin[i] = (c[0][i] * o[0] + c[1][i] * o[1]) + (c[2][i] * o[2] + grid.offset[i]);
    segment.direction[i] = (c[0][i] * d[0] + c[1][i] * d[1]) + c[2][i] * d[2];
  }
  return segment;
}

// From an object's grid to its frame: grid · unit + min.
struct ToFrame {
  float unit[3], min[3];
};

// A node of the hierarchy over the instances: eight boxes. Empty places have boxes that nothing meets.
struct SceneNode {
  alignas(32) float low[3][8], high[3][8];
  uint32_t child[8];  // a node, or an instance with kLeaf set
};
inline constexpr uint32_t kLeaf = 0x80000000;
inline constexpr size_t kDeepest = 96;  // nodes that can wait: 7 a level, and levels are log8 of 2^31 at the most

struct SceneData {
  std::vector<SceneNode> nodes;  // the first is the root; none: no instances
  std::vector<ToGrid> to_grid;
  std::vector<ToFrame> to_frame;
  // Null: without a sidecar; frame is the grid itself, many the scene's kernel's.
  std::vector<const ObjectData*> objects;
  std::vector<uint32_t> masks;
};

struct ScenePair {
  uint32_t segment, instance;
};

// Beyond this reach a transform's rounding could leave the guard band: unclassified. See spec/proofs.md, "Scenes".
inline constexpr float kFarthestReach = 0x1p16f;

// What is still open, as far as there is room.
struct OpenSink {
  std::span<OpenPair> room;
  size_t count = 0;
  bool complete = true;  // false: there are more
  void add(const OpenPair& pair) {
    if (count < room.size()) room[count++] = pair;
    else complete = false;
  }
};

struct SceneAnswers {
  Visibility* answers;  // by segment; clear at first
  OpenSink* open;       // or null
  bool done(uint32_t segment) const { return answers[segment] == Visibility::blocked; }
  void take(const ScenePair& pair, Visibility answer, float length) {
    if (answer == Visibility::clear || done(pair.segment)) return;
    answers[pair.segment] = answer;
    if (answer == Visibility::unclassified && open) open->add({pair.segment, pair.instance, length});
  }
  // Nothing is known of a segment, not even which instances it could meet.
  void give_up(uint32_t segment) {
    answers[segment] = Visibility::unclassified;
    if (open) open->complete = false;
  }
};

// A segment as the hierarchy is asked with it.
struct SceneRay {
  float origin[3], inverse[3], t_min, t_max;
};
inline constexpr float kBoxSlack = 0x1p-20f;  // of t: covers the rounding of a box test several times

// Segments from a box of origins, with a box of directions: at t they are within [origin_low + t · low, origin_high + t
// · high].
struct SceneBeam {
  float origin_low[3], origin_high[3];
  float inverse_low[3], inverse_high[3];  // of the directions' bounds
  float t_max;                            // from t = 0
};

// Where a pair's segment is, in the instance's grid.
enum class PairPlace : uint32_t { unknown, outside, ends_inside, pierces };

inline Visibility pair_answer(const ObjectData* object, PairPlace place, const LineCell& line, float t_min,
                              float t_max) {
  if (place == PairPlace::outside) return Visibility::clear;
  if (place == PairPlace::unknown || !object) return Visibility::unclassified;
  const TreeView& tree = object->tree;
  if (place == PairPlace::ends_inside && tree.margins && covers(tree.margins, line, t_min, t_max))
    place = PairPlace::pierces;
  const uint32_t bits = bits_from_slot(tree, tree.shape, top_slot(tree.shape, line), line);
  const uint32_t answers = 0b10'10'10'00u ^ (place == PairPlace::pierces ? tree.blocked_answers : 0u);
  return static_cast<Visibility>(answers >> (2 * bits) & 3u);
}

// Leads every segment through the hierarchy. boxes_met(node, ray) gives a bit for each of a node's boxes; ask(pair) may
// answer at once or later.
template <class BoxesMet, class Ask>
void walk_scene(const SceneData& scene, std::span<const Segment> segments, const SceneQuery& query,
                SceneAnswers answers, const BoxesMet& boxes_met, const Ask& ask) {
  for (uint32_t s = 0; s < segments.size() && !scene.nodes.empty(); ++s) {
    const Segment& segment = segments[s];
    SceneRay ray{{}, {}, segment.t_min, segment.t_max};
    float sum = 0;
    for (int a = 0; a < 3; ++a) {
      ray.origin[a] = segment.origin[a];
      const float d = segment.direction[a];
      ray.inverse[a] = 1 / std::copysign(std::max(std::abs(d), 1e-37f), d);
      sum += segment.origin[a] * 0 + d * 0;
    }
    if (!(sum + segment.t_min * 0 == 0) || std::isnan(segment.t_max)) {  // something is not finite
      answers.give_up(s);
      continue;
    }
    const uint32_t origin = s < query.origins.size() ? query.origins[s] : kNoInstance;
    uint32_t waiting[kDeepest];
    size_t count = 1;
    waiting[0] = 0;
    while (count > 0 && !answers.done(s)) {
      const SceneNode& node = scene.nodes[waiting[--count]];
      for (uint32_t met = boxes_met(node, ray); met; met &= met - 1) {
        const uint32_t child = node.child[std::countr_zero(met)], instance = child & ~kLeaf;
        if (!(child & kLeaf)) waiting[count++] = child;
        else if (!(scene.masks[instance] & query.mask)) continue;
        else if (instance == origin) answers.take({s, instance}, Visibility::unclassified, kGrid);
        else ask({s, instance});
      }
    }
  }
}

}  // namespace vcd
