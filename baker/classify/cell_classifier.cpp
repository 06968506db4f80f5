#include "cell_classifier.h"

namespace vcd::baker {

const Candidates& CandidatePath::of(const TriangleGroups& groups, const Cell& cell, const Shaft& shaft) {
  Level& level = levels_[cell.level];
  if (level.known && level.cell == cell) return level.candidates;
  if (cell.level == 0) {
    Level& all = levels_.back();
    if (!all.known) all.candidates = groups.all(), all.known = true;
    groups.select(shaft, all.candidates, level.candidates);
  } else {
    const Cell parent = cell.parent();
    groups.select(shaft, of(groups, parent, make_shaft(parent)), level.candidates);
  }
  level.cell = cell;
  level.known = true;
  return level.candidates;
}

}  // namespace vcd::baker
