// The cells that lines are asked of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include <tbb/enumerable_thread_specific.h>

#include "classify/cell_classifier.h"
#include "demand/asked_lines.h"

namespace vcd::baker {

using Workspaces = tbb::enumerable_thread_specific<Workspace>;

// A cell and its lines: those of [begin, end).
struct Asked {
  Cell cell;
  size_t begin, end;
  double weight;  // of the lines, at first

  // Of a heap: the heaviest first.
  bool operator<(const Asked& o) const { return weight != o.weight ? weight < o.weight : address() > o.address(); }

 private:
  uint64_t address() const { return uint64_t{cell.pair} << 32 | cell.s << 24 | cell.t << 16 | cell.u << 8 | cell.v; }
};

// Cell `cell` with its lines: those from `begin` on, before `end`, that pass through it.
inline Asked asked_cell(const std::vector<AskedLine>& lines, const Cell& cell, size_t begin, size_t end) {
  const uint32_t shift = 4 * (kKeyLevels - cell.level);
  Asked asked{cell, begin, begin, 0};
  for (; asked.end < end && lines[asked.end].key >> shift == lines[begin].key >> shift; ++asked.end)
    asked.weight += lines[asked.end].weight;
  return asked;
}

// each(const Asked&) for the children that lines are asked of.
template <class Each>
void for_children(const std::vector<AskedLine>& lines, const Asked& parent, const Each& each) {
  for (size_t i = parent.begin; i < parent.end;) {
    const Cell cell = parent.cell.child(child_of(lines[i].key, parent.cell.level + 1));
    const Asked child = asked_cell(lines, cell, i, parent.end);
    each(child);
    i = child.end;
  }
}

// The cells of a level that lines are asked of, and that neither they nor a cell above decides. Once `over` says so,
// there are none.
std::vector<Asked> undecided_cells(const CellClassifier& classifier, const std::vector<AskedLine>& lines,
                                   uint32_t level, Workspaces& workspaces, const std::function<bool()>& over);

// The deepest level that is expected to answer enough more of the lines' weight. The inner blocks for all that is asked
// come first, then bricks for the heaviest cells.
uint32_t pick_depth(const CellClassifier& classifier, const std::vector<AskedLine>& lines, uint64_t budget_bytes,
                    const std::function<bool()>& over);

}  // namespace vcd::baker
