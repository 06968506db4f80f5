// Segments and the instances that they could meet: one answer a pair, and what becomes of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <vcd/format/tree.h>
#include <vcd/runtime/scene.h>

#include "lookup/kernels.h"

namespace vcd {

struct ScenePair {
  uint32_t segment, instance;
};

// Takes down unclassified pairs, as far as there is room.
struct UnclassifiedList {
  std::span<UnclassifiedPair> room;
  size_t count = 0;
  bool complete = true;  // false: there are more
  void add(const UnclassifiedPair& pair) {
    if (count < room.size()) room[count++] = pair;
    else complete = false;
  }
};

struct SceneAnswers {
  Visibility* answers;     // by segment; clear at first
  UnclassifiedList* list;  // or null
  bool done(uint32_t segment) const { return answers[segment] == Visibility::blocked; }
  // length: anything where the place is doubtful.
  void take(const ScenePair& pair, Visibility answer, Place place, float length) {
    if (answer == Visibility::clear || done(pair.segment)) return;
    answers[pair.segment] = answer;
    if (answer == Visibility::unclassified && list)
      list->add({pair.segment, pair.instance, place == Place::doubtful ? kGrid : length});
  }
  // Nothing is known of a segment, not even which instances it could meet.
  void give_up(uint32_t segment) {
    answers[segment] = Visibility::unclassified;
    if (list) list->complete = false;
  }
};

// place: by place_of().
inline Visibility pair_answer(const LookUp& object, Place place, const LineCell& line, const Segment& segment) {
  if (!object.tree || place == Place::outside || place == Place::doubtful)
    return answer(place, CellClass::unclassified, Trust::proofs);
  const TreeView& tree = *object.tree;
  return look_up(tree, tree.shape, widened(place, tree.clearances, line, segment.t_min, segment.t_max), line);
}

}  // namespace vcd
