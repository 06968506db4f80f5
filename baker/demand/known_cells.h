// Cells whose class an earlier bake of the same geometry has found.
#pragma once

#include <optional>

#include <vcd/baker/bake.h>

#include "classify/cell_classifier.h"

namespace vcd::baker {

// Asks another classifier, and only where a tree does not know. What the tree knows: cells that it calls clear or
// blocked, that a cell which it divides has no class, and all cells of its deepest level in bricks of several classes.
// Other cells may be unclassified, or blocked by statistics, because little was asked of them.
class KnownCells : public CellClassifier {
 public:
  // Both outlive this. known: none is known where it is null.
  KnownCells(const CellClassifier& cells, const TreeView* known) : cells_(cells), known_(known) {}

  uint32_t classify(const Cell& cell, bool deepest, Workspace& workspace) const override;

  // Whether the tree divides the cell.
  bool divides(const Cell& cell) const { return known_ && cell.level < known_->shape.levels && !all_of(cell); }

 private:
  // The class of all that is below the cell. Nothing: there are several.
  std::optional<uint32_t> all_of(const Cell& cell) const;
  // The class of a cell of the tree's deepest level, if its brick has several.
  std::optional<uint32_t> in_divided_brick(const Cell& cell) const;

  const CellClassifier& cells_;
  const TreeView* known_;
};

// The tree, if its cells have the classes that the options give: method, samples and seed are the same, and classes are
// proofs or statistics of the same cells. Else null.
// samples: that a class by statistics rests on
const TreeView* usable_cells(const std::optional<KnownTree>& known, const BakeOptions& options, uint32_t samples);

}  // namespace vcd::baker
