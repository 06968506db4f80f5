// What the recursion asks at every cell, whatever the method.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <vcd/baker/cell.h>

#include "classify/aimed_rays.h"
#include "classify/crossings.h"
#include "classify/sheet.h"
#include "classify/triangle_groups.h"

namespace vcd::baker {

// The clusters that may meet the shafts of a cell and its ancestors, kept from one cell to the next.
class CandidatePath {
 public:
  // Those of a cell: selected from its parent's, and so on. The reference holds until the next call.
  const Candidates& of(const TriangleGroups& groups, const Cell& cell, const Shaft& shaft);

 private:
  struct Level {
    bool known = false;
    Cell cell{};
    Candidates candidates;
  };
  std::array<Level, 10> levels_;  // 0 … 8; the last holds all
};

// What one thread needs from cell to cell of one mesh, and what it has done.
struct Workspace {
  uint64_t rays = 0;   // traced
  uint64_t cells = 0;  // classified for a demand, and not known before
  CandidatePath path;
  Surface::Flood flood;
  std::vector<Crossing> crossings;
  std::vector<SilhouetteEdge> edges;
  struct {
    bool known = false;
    Cell cell{};
    bool blocked = false;
  } last_parent;  // that was asked by rays alone
};

class CellClassifier {
 public:
  virtual ~CellClassifier() = default;

  // A cell's class; kDeeper where its children have to be asked. deepest: it has none, so that kDeeper is never the
  // answer. Depends on nothing else. Safe from any thread, each with a workspace of its own.
  virtual uint32_t classify(const Cell& cell, bool deepest, Workspace& workspace) const = 0;
};

}  // namespace vcd::baker
