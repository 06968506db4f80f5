// Why cells have no class: what people want to know of an object before they blame the baker.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <vcd/baker/cell.h>
#include <vcd/baker/prepare.h>
#include <vcd/format/error.h>

namespace vcd::baker {

enum class Why : uint8_t {
  silhouette,  // the cell has clear and blocked lines, and on a straight way through it they change at most once
  foliage,     // on some straight way they change more often: parts or gaps are thinner than the cell is wide
  boundary,    // it looks blocked, and the sheet that blocks it ends in the cell: at a boundary or non-manifold edge
  unproven,    // it looks blocked, and no sheet is proven to block all of its lines
  known,       // a proof succeeds: the method tries none, or the class was given up, or never asked, to save bytes
};
inline constexpr size_t kWhys = 5;

// Of each cell that is unclassified, the reason. To look blocked is what 16 rays say. The straight ways are the eight
// diagonals of the cell, with eight rays each. Depends on mesh and cell only. Uses all cores.
//
// cells  of level 1 … 8
// stop   asked often, from many threads at once; true ends it with an error; may be empty
// Errors: runtime (stopped, out of memory).
Result<std::vector<Why>> why_unclassified(const PreparedMesh& mesh, std::span<const Cell> cells,
                                          const std::function<bool()>& stop = {});

}  // namespace vcd::baker
