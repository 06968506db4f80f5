// The lines that a demand asks of one object, by the cells that they pass through.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <vcd/baker/cell.h>
#include <vcd/baker/tracer.h>
#include <vcd/format/demand.h>
#include <vcd/format/line_cell.h>

#include "prepare/grid_mesh.h"

namespace vcd::baker {

// A cell of level L by the upper part of its lines' keys: a face pair, then four bits a level, child after child.
inline constexpr uint32_t kKeyLevels = 8;
inline uint64_t line_key(const LineCell& line) {
  uint64_t key = line.pair;
  for (uint32_t bit = kKeyLevels; bit-- > 0;)
    key =
        key << 4 | (line.s >> bit & 1) << 3 | (line.t >> bit & 1) << 2 | (line.u >> bit & 1) << 1 | (line.v >> bit & 1);
  return key;
}
// Which of its parent's children a line's cell of `level` is.
inline uint32_t child_of(uint64_t key, uint32_t level) { return key >> 4 * (kKeyLevels - level) & 15; }

// The upper part of the keys of all lines through a cell.
inline uint64_t cell_in_keys(const Cell& c) {
  uint64_t key = c.pair;
  for (uint32_t bit = c.level; bit-- > 0;)
    key = key << 4 | (c.s >> bit & 1) << 3 | (c.t >> bit & 1) << 2 | (c.u >> bit & 1) << 1 | (c.v >> bit & 1);
  return key;
}

struct AskedLine {
  uint64_t key;
  double weight;
  bool by_blocked;  // a blocked cell answers the segment, not only a clear one: it pierces the box
};

// The lines of segments that some class of their cell can answer, in the order of their keys. Left out are those that
// the box alone answers, that cannot be looked up, and that end inside the box on a line that meets the mesh.
// clearances: of the mesh, kClearanceBytes bytes.
std::vector<AskedLine> asked_lines(const GridMesh& mesh, const Tracer& tracer, const uint8_t* clearances,
                                   std::span<const AskedSegment> segments);

}  // namespace vcd::baker
